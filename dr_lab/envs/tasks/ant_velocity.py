"""A four-legged machine walks forwards at a velocity that it is not told."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.bounds import Finite, require_range
from dr_lab.envs.task import Change
from dr_lab.envs.tasks.tasked_ant import TaskedAnt
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class AntVelocity(TaskedAnt):
    """`TaskedAnt` with r_0 − |v_x − v*|, v_x being the torso's mean velocity in a step.

    Attributes: as `TaskedAnt`, and
        velocity_range: of v*, lowest and highest, m/s; nominal is the middle.
        right_reward: r_0, for the right velocity.

    Raises:
        ConfigError: the range is none.
    """

    velocity_range: Sequence[float]
    right_reward: Finite

    def __post_init__(self) -> None:
        super().__post_init__()
        require_range(self.velocity_range, "env.task.velocity_range", "m/s")

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The velocity."""
        low, high = self.velocity_range
        return (Parameter("goal.velocity", "m/s", 0.5 * (low + high), low, high),)

    def asked(self, change: Change) -> Array:
        """How near the velocity is."""
        return self.right_reward - np.abs(change.velocity[:, 0] - change.values["goal.velocity"])
