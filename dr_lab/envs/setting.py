"""A machine and its task: what `conf/env` describes."""

import math
from dataclasses import dataclass

from dr_lab.envs.mujoco_env import MujocoEnv
from dr_lab.envs.task import Task, context_space
from dr_lab.errors import require_numbers
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.model import Model
from dr_lab.randomizers.context_source import ContextSource


@dataclass(frozen=True, kw_only=True)
class Setting:
    """What an environment is made of, apart from how many there are and where their contexts come from.

    Attributes:
        name: for run folders and reports.
        model: the machine; its parameters and those of the task make up the context.
        task: what it is to do.
        show_context: whether the policy sees the context.
        infeasible_return: highest return of an episode whose context is infeasible; to be below what others return.
        speed_limit: of every joint of a simulation that has not diverged, m/s or rad/s; to be above what is reached.
            Runs of earlier versions have none.

    Raises:
        ConfigError: the speed limit is not above 0.
    """

    name: str
    model: Model
    task: Task
    show_context: bool
    infeasible_return: float
    speed_limit: float = math.inf

    def __post_init__(self) -> None:
        require_numbers(self, "env", positive=("speed_limit",))

    @property
    def space(self) -> ContextSpace:
        """The context: parameters of the machine, then of the task."""
        return context_space(self.model, self.task)

    def make(
        self,
        randomizer: ContextSource | None,
        slots: int,
        seed: int,
        threads: int | None = None,
        *,
        staggered: bool = False,
    ) -> MujocoEnv:
        """The environment; arguments as `MujocoEnv`."""
        return MujocoEnv(
            self.model,
            self.task,
            randomizer,
            slots,
            seed,
            show_context=self.show_context,
            infeasible_return=self.infeasible_return,
            speed_limit=self.speed_limit,
            threads=threads,
            staggered=staggered,
        )
