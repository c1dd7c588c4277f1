"""Many policies that act at once, each for its own share of the slots."""

import copy
from collections.abc import Callable, Mapping, Sequence
from itertools import chain
from typing import Any, Self, cast

import torch
from torch import Tensor, nn
from torch.func import stack_module_state

from dr_lab.errors import ConfigError
from dr_lab.networks.actor import Actor
from dr_lab.networks.gaussian import Gaussian
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.restack import restack


class PolicyStack(nn.Module):
    """N policies of one architecture; of n slots, policy k acts for those from k·n/N up to (k + 1)·n/N.

    Their parameters and statistics are stacked, so that a layer of all is one batched matrix product. Every policy
    draws its noise from its own random numbers, so that its actions are those that it would take alone.

    The policies may be trained one by one: `refresh` takes over what they have learnt, and every collector calls it
    before a batch.

    Attributes:
        policies: the N policies.

    Args:
        policies: made with the same arguments, the seed excepted.

    Raises:
        ConfigError: there is none, or they differ in more than their values.
    """

    def __init__(self, policies: Sequence[Actor]) -> None:
        super().__init__()
        _require_alike(policies)
        self.policies = nn.ModuleList(policies)
        # In a tuple it is no part of this module: what it holds is a copy, not another state to be saved.
        self._together = (copy.deepcopy(policies[0]),)
        self.refresh()

    @property
    def generator(self) -> torch.Generator:
        """Random numbers of the first policy, by which a collector seeds its workers."""
        return self._members[0].generator

    def refresh(self) -> None:
        """Act as the policies are now."""
        restack(self._together[0], self._members)

    def stacked(self) -> dict[str, Tensor]:
        """Copies of the parameters by name, shape (N, …), for ``torch.vmap(actor.distribution)``."""
        return {name: value.detach() for name, value in stack_module_state(list(self._members))[0].items()}

    @torch.no_grad()
    def assign(self, parameters: Mapping[str, Tensor]) -> None:
        """Give policy k the rows k of parameters as `stacked` gives them."""
        for k, policy in enumerate(self._members):
            for name, parameter in policy.named_parameters():
                parameter.copy_(parameters[name][k])
        self.refresh()

    @torch.no_grad()
    def forward(self, observation: Tensor) -> Tensor:
        """An action (n, nu) drawn for observations (n, o)."""
        rows, together = self._dealt(observation), self._together[0]
        noise = rows.new_empty((*rows.shape[:2], together.reach.shape[-1]))
        for part, policy in zip(noise, self._members, strict=True):
            part.normal_(generator=policy.generator)
        return together.act(rows, noise).flatten(0, 1)

    def mean(self, observation: Tensor) -> Tensor:
        """The action (n, nu) without noise."""
        return self._together[0].mean(self._dealt(observation)).flatten(0, 1)

    def policy_of_slot(self, slots: int) -> Tensor:
        """Number of the policy that acts for each slot, int64, shape (slots,)."""
        return torch.arange(len(self.policies)).repeat_interleave(self._share(slots))

    def of_worker(self, worker: int, workers: int) -> Self:
        """The policies of the slots that a worker plays, where each plays an equal share of all, in their order.

        Raises:
            ConfigError: the worker would play more slots for one policy than for another.
        """
        count = len(self.policies)
        if count % workers and workers % count:
            raise ConfigError(
                f"{workers} workers cannot share {count} policies equally. Choose collector.workers such that one "
                "number divides the other."
            )
        last = -(-(worker + 1) * count // workers)
        return type(self)(self._members[worker * count // workers : last])

    def reseed(self, seed: int) -> None:
        """Draw actions by the random numbers of this seed from here on, every policy by others."""
        draw = torch.Generator().manual_seed(seed)
        for policy, own in zip(self._members, torch.randint(2**62, (len(self.policies),), generator=draw), strict=True):
            policy.reseed(int(own))

    def load_state_dict(self, *args: Any, **kwargs: Any) -> Any:  # noqa: ANN401 (torch's signature)
        """As torch's, and act so."""
        loaded = super().load_state_dict(*args, **kwargs)
        self.refresh()
        return loaded

    def _apply(self, fn: Callable[[Tensor], Tensor], recurse: bool = True) -> Self:
        """As torch's, by which `to` moves tensors to a device: what acts goes along."""
        self._together[0]._apply(fn, recurse)
        return super()._apply(fn, recurse)

    @property
    def _members(self) -> Sequence[Actor]:
        return cast(Sequence[Actor], self.policies)

    def _dealt(self, values: Tensor) -> Tensor:
        """Values (n, …, k) of all slots as rows of each policy, shape (N, n/N·…, k)."""
        self._share(len(values))
        return values.reshape(len(self.policies), -1, values.shape[-1])

    def _share(self, slots: int) -> int:
        count = len(self.policies)
        if slots % count:
            raise ConfigError(
                f"{count} policies cannot share {slots} episodes equally. Choose a multiple: episodes={count}, "
                f"{2 * count}, …"
            )
        return slots // count


class GaussianPolicyStack(PolicyStack):
    """As `PolicyStack`, of policies that know how likely their actions are.

    Args: as `PolicyStack`.
    """

    def __init__(self, policies: Sequence[GaussianActor]) -> None:
        super().__init__(policies)

    def log_prob(self, observation: Tensor, action: Tensor) -> Tensor:
        """Log-density of actions (n, …, nu) at observations (n, …, o) under the slot's policy, shape (n, …)."""
        return self._all.log_prob(self._dealt(observation), self._dealt(action)).reshape(action.shape[:-1])

    @torch.no_grad()
    def distribution(self, observation: Tensor) -> Gaussian:
        """π(u|o) of the slot's policy, over actions scaled to ±1, at observations (n, …, o) as they are."""
        mean = self._all.body(self._all.normaliser(self._dealt(observation)))
        shape = (*observation.shape[:-1], mean.shape[-1])
        return Gaussian(mean.reshape(shape), self._all.log_std.expand_as(mean).reshape(shape))

    @property
    def _all(self) -> GaussianActor:
        return cast(GaussianActor, self._together[0])


def _require_alike(policies: Sequence[Actor]) -> None:
    if not policies:
        raise ConfigError("There are no policies; expected at least one to act.")
    first = _architecture(policies[0])
    for k, policy in enumerate(policies):
        other = _architecture(policy)
        for name in first.keys() | other.keys():
            if first.get(name) != other.get(name):
                raise ConfigError(
                    f"Policy {k} has {name} = {other.get(name)}, policy 0 {first.get(name)}; expected policies that "
                    "differ in their seed and in what they have learnt."
                )


def _architecture(policy: Actor) -> dict[str, Any]:
    """All that makes a policy up, but not the values of its tensors."""
    kinds: dict[str, Any] = {}
    for path, module in policy.named_modules():
        kinds[f"{path} kind"] = type(module).__name__
        plain = {name: value for name, value in vars(module).items() if isinstance(value, bool | int | float | str)}
        kinds |= {f"{path}.{name}".strip("."): value for name, value in plain.items()}
    tensors = chain(policy.named_parameters(), policy.named_buffers())
    return kinds | {f"the shape of {name}": tuple(tensor.shape) for name, tensor in tensors}
