"""Navigation in the plane, with the goal as context."""

from dataclasses import dataclass
from pathlib import Path

import mujoco

from dr_lab.bounds import Positive, require_bounds
from dr_lab.envs.batched_env import BatchedEnv
from dr_lab.envs.environment import Environment
from dr_lab.envs.nav2d.episodes import WalkingEpisodes
from dr_lab.envs.nav2d.walk import Walk
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.parameter import Parameter
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class Nav2D(Environment):
    """A point walks from the origin to a goal in the plane; see `WalkingEpisodes` for what is moved and rewarded.

    The policy sees where it is. Unless `show_context` says otherwise, it has to find out by its reward where the goal
    is.

    Source: Finn, Abbeel, Levine 2017, "Model-agnostic meta-learning for fast adaptation of deep networks", §5.3.

    Attributes: as `Environment`, and
        task: how far a step goes, and when it ends.
        goal_range: largest |x| and |y| of a goal, m.
        mjcf: file of the scene, whose body ``goal`` and geom ``rail`` follow the context and the range.

    Raises:
        ConfigError: the range is not above 0.
    """

    task: Walk
    goal_range: Positive
    mjcf: str

    def __post_init__(self) -> None:
        require_bounds(self, "env")

    @property
    def space(self) -> ContextSpace:
        """The goal; its nominal place is the start."""
        far = self.goal_range
        return ContextSpace(tuple(Parameter(name, "m", 0.0, -far, far) for name in ("goal.x", "goal.y")))

    @property
    def time_limit(self) -> int:
        """Control steps after which an episode is cut."""
        return self.task.time_limit

    @property
    def seconds(self) -> float:
        """Length of a control step, s."""
        return self.task.seconds

    def make(
        self,
        source: ContextSource | None,
        slots: int,
        seed: int,
        threads: int | None = None,
        *,
        staggered: bool = False,
    ) -> BatchedEnv:
        """Points that walk side by side; one thread moves all."""
        del threads
        show = self.show_context
        return BatchedEnv(
            WalkingEpisodes(self.space, self.task, source, slots, seed, show_context=show, staggered=staggered)
        )

    def goal(self, z: Array) -> Array:
        """The context."""
        return z

    def scene(self, z: Array) -> mujoco.MjModel:
        """The point on its rail, and the goal where the context has it."""
        spec = mujoco.MjSpec.from_file(self.mjcf)
        spec.body("goal").pos[:2] = z
        spec.geom("rail").size[1] = 1.2 * self.goal_range  # what is shown then holds every goal
        return spec.compile()

    def scene_xml(self) -> str:
        """The scene as MJCF text, the goal at its nominal place."""
        return Path(self.mjcf).read_text(encoding="utf-8")
