"""The contract of an expert, and the trajectories that it gives."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import torch
from torch import Tensor

from dr_lab.errors import ConfigError


@dataclass(frozen=True)
class Demonstrations:
    """Control steps of whole trajectories, one after the other, k in all.

    Attributes:
        observation: before each, shape (k, o).
        action: what was done, within its bounds, shape (k, nu).
        after: the observation after it, shape (k, o).
        lengths: control steps of each trajectory.
    """

    observation: Tensor
    action: Tensor
    after: Tensor
    lengths: tuple[int, ...]

    @classmethod
    def of(cls, courses: Sequence[tuple[Tensor, Tensor]]) -> Self:
        """Out of the courses of trajectories.

        Args:
            courses: observations (t + 1, o) and actions (t, nu) of each.
        """
        return cls(
            torch.cat([seen[:-1] for seen, _ in courses]).float(),
            torch.cat([done for _, done in courses]).float(),
            torch.cat([seen[1:] for seen, _ in courses]).float(),
            tuple(len(done) for _, done in courses),
        )

    def transitions(self, hidden: int) -> Tensor:
        """(o, a, o′) side by side, shape (k, 2(o − h) + nu).

        Args:
            hidden: h, how many of the observations, the last ones, are left out.
        """
        shown = self.observation.shape[1] - hidden
        return torch.cat([self.observation[:, :shown], self.action, self.after[:, :shown]], 1)

    def require_widths(self, observation: int, action: int, origin: str) -> None:
        """Check that the trajectories are of the task that is trained.

        Args:
            observation: width that is expected.
            action: width that is expected.
            origin: which part asks, for the message.

        Raises:
            ConfigError: they are not.
        """
        given = (self.observation.shape[1], self.action.shape[1])
        if given != (observation, action):
            raise ConfigError(
                f"The expert of {origin} sees {given[0]} numbers and does {given[1]}; the policy that is trained sees "
                f"{observation} and does {action}. Give trajectories of the same env, with the same env.show_context."
            )


class Expert(ABC):
    """Gives trajectories on the task that is trained, whoever or whatever acted in them."""

    @abstractmethod
    def demonstrations(self) -> Demonstrations:
        """All trajectories; they are looked for at the first call.

        Raises:
            DataError: they cannot be read.
            ConfigError: there are fewer than asked for.
        """


def require_enough(found: int, wanted: int | None, origin: str) -> None:
    """Check that there are as many trajectories as asked for.

    Args:
        found: how many there are.
        wanted: how many are asked for; None stands for one at least.
        origin: where they were looked for.

    Raises:
        ConfigError: there are fewer.
    """
    if found < (wanted or 1):
        raise ConfigError(
            f"{origin} holds {found} trajectories; {wanted or 1} are asked for. Play more with dr-lab evaluate "
            "evaluator=demonstrations evaluator.episodes=N, or lower expert.episodes."
        )
