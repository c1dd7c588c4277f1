"""Policies that each master one domain."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, cast

from tensordict import TensorDict
from torch import Tensor

from dr_lab.algorithms.algorithm import Interface
from dr_lab.algorithms.ppo.ppo import PPO
from dr_lab.algorithms.ppo.ppo_stack import PPOStack
from dr_lab.bounds import Count, require_bounds
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.feasible_contexts import feasible_contexts
from dr_lab.collectors.first_episodes import first_episodes
from dr_lab.seeding import derived_seed, stream
from dr_lab.trajectory import Array


class Teachers(PPOStack):
    """N policies, each trained by PPO in one context of its own, which is drawn from p(z) once.

    Before it is trained in, a domain is played; one that is infeasible is drawn anew.

    Args:
        interface: what the policies are connected to.
        seed: of the policies and their domains.
        learner: makes PPO for one policy, from the interface and a seed.
        count: N.
        slots: episodes that run side by side, a multiple of N.

    Attributes:
        domains: a context for each, shape (N, n); None before they are drawn.

    Raises:
        ConfigError: a number is out of its range, or the policies cannot share the slots equally.
    """

    def __init__(
        self, interface: Interface, seed: int, learner: Callable[[Interface, int], PPO], count: Count, slots: int
    ) -> None:
        self.count, self._slots = count, slots
        require_bounds(self, "algorithm.teachers", Teachers)
        super().__init__([learner(interface, derived_seed(seed, "teacher", k)) for k in range(count)])
        self.acting.policy_of_slot(slots)  # which it refuses where they cannot share them
        self.domains: Array | None = None
        self._rng = stream(seed, "domains")

    def slot_contexts(self, experience: Experience) -> Array:
        """The context of every slot: that of the policy that acts there, shape (slots, n)."""
        if self.domains is None:
            self.domains = self._draw(experience)
        return self.domains.repeat(self._slots // self.count, axis=0)

    def update(self, batch: TensorDict) -> dict[str, float]:
        """As `PPOStack`; gives also the mean return of the policy that does worst in its domain."""
        first = first_episodes(batch)
        reward = cast(Tensor, batch["next", "reward"]).squeeze(-1)
        returns = (reward * first).sum(1).unflatten(0, (self.count, -1)).mean(1)
        return {**super().update(batch), "worst_teacher": float(returns.min())}

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {**super().state_dict(), "domains": self.domains, "rng": self._rng.bit_generator.state}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        super().load_state_dict(state)
        self.domains, self._rng.bit_generator.state = state["domains"], state["rng"]

    def _draw(self, experience: Experience) -> Array:
        owners = [f"teacher {k}" for k in range(self.count)]
        return feasible_contexts(experience, self._rng, owners, partial(experience.play, self.members[0].actor))
