"""A four-legged machine walks to a place that it is not told."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from dr_lab.bounds import Finite, Positive
from dr_lab.envs.task import Change
from dr_lab.envs.tasks.ant_body import TORSO
from dr_lab.envs.tasks.tasked_ant import TaskedAnt
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class AntNavigation(TaskedAnt):
    """`TaskedAnt` with r_0 − |x − x*| − |y − y*|, (x, y) being where the torso is after the step.

    Attributes: as `TaskedAnt`, and
        goal_range: largest |x*| and |y*|, m; nominal is the start.
        right_reward: r_0, for the right place.
    """

    goal_range: Positive
    right_reward: Finite

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The place."""
        far = self.goal_range
        return tuple(Parameter(name, "m", 0.0, -far, far) for name in ("goal.x", "goal.y"))

    def goal(self, values: Mapping[str, float]) -> Array:
        """The place."""
        return np.array([values["goal.x"], values["goal.y"]])

    def asked(self, change: Change) -> Array:
        """How near the place is."""
        goal = np.column_stack([change.values["goal.x"], change.values["goal.y"]])
        return self.right_reward - np.abs(change.fields["xpos"][:, TORSO, :2] - goal).sum(1)
