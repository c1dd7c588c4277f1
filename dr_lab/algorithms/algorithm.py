"""The contract of an algorithm: what learns a policy from batches of experience."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import torch
from tensordict import TensorDict

from dr_lab.collectors.collector import Policy, SeededPolicy
from dr_lab.collectors.experience import Experience
from dr_lab.seeding import derived_seed
from dr_lab.trajectory import Array

CPU = torch.device("cpu")


@dataclass(frozen=True)
class Interface:
    """What a policy is connected to.

    Attributes:
        observation: width of an observation.
        low: lowest action, shape (nu,), in the actuators' unit.
        high: highest action, shape (nu,).
        device: on which it is learnt; it acts on the CPU.
    """

    observation: int
    low: Array
    high: Array
    device: torch.device = CPU


class Algorithm(ABC):
    """Learns from batches as a `Collector` gives them, on the device of its interface.

    Networks, optimisers and what else enters losses are made there, and batches come there. Random numbers are drawn on
    the CPU and moved, so that a run sees the same on every device. States are loaded from tensors on any.

    Attributes:
        batch_frames: control steps, over all episodes, that one update wants.
    """

    batch_frames: int

    @property
    def name(self) -> str:
        """As a report calls it."""
        return type(self).__name__

    @property
    @abstractmethod
    def policies(self) -> Mapping[str, Policy]:
        """What is learnt and kept, by name; most algorithms have one, ``policy``, which explores."""

    @property
    def domains(self) -> Array | None:
        """The contexts on which it trains where these stay the same, shape (N, n); None where episodes draw theirs."""
        return None

    @property
    def judged_by_return(self) -> bool:
        """Whether what the deployed policy returns as it is says how good it is, so that the best of some is chosen."""
        return True

    @property
    def first(self) -> int:
        """Control steps of training before which nothing is learnt."""
        return 0

    @property
    def collecting(self) -> Policy:
        """What acts while experience is collected: ``policy``, unless others that follow from it do."""
        return self.policies["policy"]

    @property
    @abstractmethod
    def deployed(self) -> Policy:
        """What is evaluated and deployed: without exploration."""

    def iterate(self, experience: Experience) -> Mapping[str, float]:
        """One iteration: collect what it takes, one batch unless said otherwise, and learn from it.

        Args:
            experience: of the present policy.

        Returns:
            Figures to be recorded, by name.
        """
        return self.update(experience.collect())

    @abstractmethod
    def update(self, batch: TensorDict) -> Mapping[str, float]:
        """Learn from one batch.

        Args:
            batch: size [n, steps], collected with the present policy.

        Returns:
            Figures to be recorded, by name.
        """

    def begin_schedules(self) -> None:  # noqa: B027 (few have one)
        """Let what changes with the control steps seen begin anew; by default there is nothing of the kind.

        A policy that is trained on would else be held by a learning rate that has fallen to 0, or by old samples.
        """

    def forget_episodes(self) -> None:  # noqa: B027 (few remember any)
        """Let go of what is known of episodes that go on, because new ones begin; by default nothing is."""

    def explore_anew(self, seed: int) -> None:
        """Explore and learn with other random numbers; a state that was loaded has brought those of its run.

        Args:
            seed: of them, so that what goes on from one state with several seeds does so independently.
        """
        own = getattr(self, "generator", None)  # what draws from torch's has none of its own
        if isinstance(own, torch.Generator):
            own.manual_seed(derived_seed(seed, "explore_anew", "algorithm"))
        for name, policy in self.policies.items():
            if isinstance(policy, SeededPolicy):
                policy.reseed(derived_seed(seed, "explore_anew", name))

    @abstractmethod
    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs: networks, normalisers, optimisers, random numbers, counters."""

    @abstractmethod
    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
