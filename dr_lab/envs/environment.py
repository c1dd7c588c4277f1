"""The contract of an environment: what `conf/env` describes, whatever engine plays its episodes."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import mujoco

from dr_lab.envs.batched_env import BatchedEnv
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class Environment(ABC):
    """A machine and its task, apart from how many of them play and where their contexts come from.

    Attributes:
        name: for run folders and reports.
        show_context: whether the policy sees the context behind the observation, as (z − low) / (high − low).
    """

    name: str
    show_context: bool

    @property
    @abstractmethod
    def space(self) -> ContextSpace:
        """The context: parameters of the machine, then of the task."""

    @property
    @abstractmethod
    def time_limit(self) -> int:
        """Control steps after which an episode is cut."""

    @property
    @abstractmethod
    def seconds(self) -> float:
        """Length of a control step, s."""

    @abstractmethod
    def make(
        self,
        source: ContextSource | None,
        slots: int,
        seed: int,
        threads: int | None = None,
        *,
        staggered: bool = False,
    ) -> BatchedEnv:
        """Episodes that run side by side.

        Args:
            source: p(z), from which every new episode draws; None for the nominal context.
            slots: number of episodes.
            seed: of all random draws.
            threads: cores for the physics; None takes every core this process may use. It changes no result.
            staggered: whether first episodes are cut at different ages; for training alone.
        """

    def goal(self, z: Array) -> Array | None:
        """Where an episode in a context (parameters,) is to go, in the plane of the state's first two positions.

        Returns:
            Its x and y, m, shape (2,); None where it is not to go to a place, as unless said otherwise.
        """
        del z
        return None

    @abstractmethod
    def scene(self, z: Array) -> mujoco.MjModel:
        """What shows an episode in a context (parameters,): the model that the states of its slots are positions of.

        Where MuJoCo plays the episodes it is the machine itself, else a likeness that is never simulated.
        """

    @abstractmethod
    def scene_xml(self) -> str:
        """The scene at the nominal context as MJCF text."""
