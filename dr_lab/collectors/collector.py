"""The contract of a collector: batches of experience, one after the other."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Protocol, Self, runtime_checkable

import torch
from tensordict import TensorDict
from torch import Tensor

from dr_lab.trajectory import Array


class Policy(Protocol):
    """What acts: observation (n, o) to action (n, nu), drawn at random where the policy is stochastic."""

    def __call__(self, observation: Tensor) -> Tensor:
        """The action."""
        ...


Drive = Policy | Array
"""A policy, or commands of each episode, shape (count, steps, nu), in the actuators' unit."""


@runtime_checkable
class StochasticPolicy(Protocol):
    """A policy that knows how likely its actions are."""

    def log_prob(self, observation: Tensor, action: Tensor) -> Tensor:
        """Log-density of actions (…, nu) at observations (…, o), shape (…)."""
        ...


@runtime_checkable
class SeededPolicy(Protocol):
    """A policy that draws from random numbers of its own; others draw from torch's.

    Attributes:
        generator: of them, by which a collector seeds its workers.
    """

    generator: torch.Generator

    def reseed(self, seed: int) -> None:
        """Draw by the random numbers of this seed from here on."""
        ...


@runtime_checkable
class PoliciesBySlot(Protocol):
    """Policies that share the slots equally, each acting for its own."""

    def refresh(self) -> None:
        """Act as the policies are now."""
        ...

    def policy_of_slot(self, slots: int) -> Tensor:
        """Number of the policy that acts for each slot, int64, shape (slots,)."""
        ...

    def of_worker(self, worker: int, workers: int) -> Policy:
        """The policies of the slots that one of several workers plays, each of which plays an equal share."""
        ...


class Collector(ABC):
    """An endless iterator over batches of experience, collected with the policy as it is then.

    A batch has size [n, steps], time along the second dimension, and the keys ``observation``, ``context``,
    ``proposal`` (n, steps; which proposal of their source the contexts are), ``action``, ``action_log_prob`` (n, steps)
    where the policy is stochastic, ``policy`` (n, steps; int64) where several share the slots, and under ``next``
    ``observation``, ``context``, ``proposal``, ``reward``, ``done``, ``terminated``, ``truncated``, ``infeasible`` (the
    context is, which terminates). Where an episode ended, ``("next", "observation")`` is its own last observation, and
    the row after it begins another.
    """

    def __iter__(self) -> Iterator[TensorDict]:
        """Itself."""
        return self

    def __next__(self) -> TensorDict:
        """The next batch, which is the caller's own."""
        policy = self._policy
        with torch.no_grad(), _one_thread():
            if isinstance(policy, PoliciesBySlot):
                policy.refresh()
            batch = self._collect()
            if isinstance(policy, PoliciesBySlot):
                slots, steps = batch.shape
                batch.set("policy", policy.policy_of_slot(slots)[:, None].repeat(1, steps))
            if isinstance(policy, StochasticPolicy):
                batch.set("action_log_prob", policy.log_prob(batch["observation"], batch["action"]))
        return batch

    def __enter__(self) -> Self:
        """Itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()

    def __init__(self, policy: Policy) -> None:
        self._policy = policy

    @abstractmethod
    def _collect(self) -> TensorDict:
        """The next batch without log-probabilities."""

    @abstractmethod
    def begin(self, z: Array | None) -> None:
        """Begin new episodes in all slots.

        Args:
            z: context of every slot, which also its further episodes have, shape (n, parameters); None draws them.
        """

    def close(self) -> None:  # noqa: B027 (most have nothing to end)
        """End what runs in the background, if anything does."""

    @abstractmethod
    def state_dict(self) -> dict[str, Any]:
        """All that the coming batches depend on besides the policy and torch's random numbers."""

    @abstractmethod
    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Go on where an equal collector's `state_dict` was taken."""


@contextmanager
def _one_thread() -> Iterator[None]:
    """Leave the cores to the physics: a small network gains nothing from a second thread and takes it from there."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)
