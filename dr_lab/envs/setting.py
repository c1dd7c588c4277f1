"""A machine in MuJoCo and its task."""

import math
from dataclasses import dataclass

import mujoco

from dr_lab.bounds import Finite, Limit, require_bounds
from dr_lab.envs.environment import Environment
from dr_lab.envs.mujoco_env import MujocoEnv
from dr_lab.envs.task import Task, context_space
from dr_lab.envs.task_outputs import require_methods
from dr_lab.errors import ConfigError, ModelError
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.mjcf import mjcf
from dr_lab.physics.model import Model
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class Setting(Environment):
    """An environment that MuJoCo plays.

    Attributes: as `Environment`, and
        model: the machine; its parameters and those of the task make up the context.
        task: what it is to do.
        infeasible_return: highest return of an episode whose context is infeasible; to be below what others return.
        speed_limit: of every joint of a simulation that has not diverged, m/s or rad/s; to be above what is reached.
            Runs of earlier versions have none.

    Raises:
        ConfigError: a number is out of its range, or a field of the task hides a method of its contract.
    """

    model: Model
    task: Task
    infeasible_return: Finite
    speed_limit: Limit = math.inf

    def __post_init__(self) -> None:
        require_bounds(self, "env")
        require_methods(self.task)

    @property
    def space(self) -> ContextSpace:
        """The context: parameters of the machine, then of the task."""
        return context_space(self.model, self.task)

    @property
    def time_limit(self) -> int:
        """Control steps after which an episode is cut."""
        return self.task.time_limit

    @property
    def seconds(self) -> float:
        """Length of a control step, s."""
        return self.task.frame_skip * float(self.model.nominal().opt.timestep)

    def make(
        self,
        source: ContextSource | None,
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
            source,
            slots,
            seed,
            show_context=self.show_context,
            infeasible_return=self.infeasible_return,
            speed_limit=self.speed_limit,
            threads=threads,
            staggered=staggered,
        )

    def goal(self, z: Array) -> Array | None:
        """As the task says."""
        return self.task.goal(self.space.mapping(z))

    def scene(self, z: Array) -> mujoco.MjModel:
        """The machine in a context; the nominal one where the context does not compile, so that nothing moves in it."""
        try:
            return self.model.compile(z[: len(self.model.space.names)])
        except ModelError:
            return self.model.nominal()

    def scene_xml(self) -> str:
        """The nominal machine as MJCF text."""
        return mjcf(self.model, self.model.space.nominal)


def require_mujoco(environment: Environment, wanted: str) -> Setting:
    """The environment, where MuJoCo plays it.

    Args:
        environment: any.
        wanted: what needs MuJoCo, as it is chosen on the command line.

    Raises:
        ConfigError: another engine does.
    """
    if not isinstance(environment, Setting):
        raise ConfigError(
            f"{wanted} plays another machine beside that of the environment, from the same states, and needs one that "
            f"MuJoCo simulates; env={environment.name} is played by another engine. Choose an environment with a model "
            "(its configuration has env.model)."
        )
    return environment
