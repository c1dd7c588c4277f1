"""Episodes as one batched TorchRL environment."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from tensordict import TensorDict, TensorDictBase
from torch import Tensor
from torchrl.data import Binary, Bounded, Composite, Unbounded
from torchrl.envs import EnvBase

from dr_lab.envs.slots import EpisodeSlots, StepOutcome
from dr_lab.trajectory import Array

_DONE = ("done", "terminated", "truncated")
_FLAGS = (*_DONE, "infeasible")


class BatchedEnv(EnvBase):
    """n episodes of a task as one TorchRL environment of batch size [n].

    Keys: ``observation`` (n, o) and ``context`` (n, parameters; SI units) of float32, ``proposal`` (n,) of contexts'
    source, ``action`` (n, nu) in the actuators' unit, ``reward`` (n, 1), ``done``, ``terminated``, ``truncated``,
    ``infeasible`` (n, 1). A reset of some slots touches no other.

    Args:
        episodes: the episodes in NumPy, on whatever engine.

    Attributes:
        episodes: the same.
    """

    def __init__(self, episodes: EpisodeSlots) -> None:
        super().__init__(device="cpu", batch_size=torch.Size([episodes.nsim]))
        self.episodes = episodes
        self._make_specs()
        self._never = torch.zeros(episodes.nsim, 1, dtype=torch.bool)
        self._remember_contexts()

    def set_contexts(self, z: Array | None) -> None:
        """Let slot i begin every further episode with z[i], shape (n, parameters); None draws them again."""
        self.episodes.give_contexts(z)

    def current(self) -> TensorDict:
        """What the policy sees now of the running episodes."""
        root = {"observation": single(self.episodes.observation), **self._contexts}
        return self._tensordict({**root, **dict.fromkeys(_FLAGS, self._never)})

    def state_dict(self, *args: Any, **kwargs: Any) -> dict[str, Any]:  # noqa: ANN401 (torch's signature)
        """All that the episodes' future depends on."""
        del args, kwargs
        return self.episodes.state_dict()

    def load_state_dict(  # pyright: ignore[reportIncompatibleMethodOverride] (there are no keys to match)
        self,
        state_dict: Mapping[str, Any],
        *args: Any,  # noqa: ANN401
        **kwargs: Any,  # noqa: ANN401
    ) -> None:
        """Go on where an equal environment's `state_dict` was taken."""
        del args, kwargs
        self.episodes.load_state_dict(state_dict)
        self._remember_contexts()

    def _make_specs(self) -> None:
        episodes = self.episodes
        n, width = episodes.observation.shape
        one = torch.Size((n, 1))
        self.observation_spec = Composite(
            observation=Unbounded(torch.Size((n, width)), dtype=torch.float32),
            context=Unbounded(torch.Size(episodes.contexts.shape), dtype=torch.float32),
            proposal=Unbounded(torch.Size((n,)), dtype=torch.int64),
            infeasible=Binary(shape=one, dtype=torch.bool),  # beside done, which TorchRL would take as another end
            shape=(n,),
        )
        low, high = (single(bound).expand(n, -1) for bound in (episodes.low, episodes.high))
        self.action_spec = Bounded(low, high, dtype=torch.float32)
        self.reward_spec = Unbounded(one, dtype=torch.float32)
        self.full_done_spec = Composite({key: Binary(shape=one, dtype=torch.bool) for key in _DONE}, shape=(n,))

    def _reset(self, tensordict: TensorDictBase | None = None, **kwargs: object) -> TensorDict:
        del kwargs
        mask = None if tensordict is None else tensordict.get("_reset", None)
        rows = np.arange(self.episodes.nsim) if mask is None else np.flatnonzero(mask.numpy())
        self._begin(rows)
        return self.current()

    def _step(self, tensordict: TensorDictBase) -> TensorDict:
        return self._after(self.episodes.step(tensordict.get("action").numpy()))

    def _step_and_maybe_reset(self, tensordict: TensorDictBase) -> tuple[TensorDictBase, TensorDictBase]:
        """The same as TorchRL's, without its checks and copies."""
        outcome = self.episodes.step(tensordict.get("action").numpy())
        after = self._after(outcome)
        tensordict.set("next", after)
        ended = np.flatnonzero(outcome.done)
        if len(ended):
            self._begin(ended)
            return tensordict, self.current()
        kept = {"observation": after.get("observation"), **self._contexts}
        return tensordict, self._tensordict({**kept, **dict.fromkeys(_FLAGS, self._never)})

    def _begin(self, rows: np.ndarray) -> None:
        self.episodes.begin(rows)
        self._remember_contexts()

    def _remember_contexts(self) -> None:
        """As tensors, which stay the same from step to step."""
        episodes = self.episodes
        self._contexts = {"context": single(episodes.contexts), "proposal": torch.from_numpy(episodes.proposals)}

    def _after(self, outcome: StepOutcome) -> TensorDict:
        values = {
            "observation": single(outcome.observation),
            **self._contexts,
            "reward": single(outcome.reward[:, None]),
            **{flag: torch.from_numpy(getattr(outcome, flag)[:, None]) for flag in _FLAGS},
        }
        return self._tensordict(values)

    def _tensordict(self, values: dict[str, Tensor]) -> TensorDict:
        return TensorDict._new_unsafe(values, batch_size=self.batch_size, device=self.device)

    def _set_seed(self, seed: int | None) -> None:
        """Every slot's stream is keyed by the seed given to the constructor; TorchRL's global seeding changes none."""


def single(values: Array) -> Tensor:
    """A new float32 tensor of the values; torch's own memory is aligned, on which a network's last digit depends."""
    return torch.from_numpy(values).float()
