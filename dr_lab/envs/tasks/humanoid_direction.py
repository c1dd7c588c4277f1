"""A two-legged machine walks in a direction that it is not told."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.bounds import require_range
from dr_lab.envs.task import Change, Fields
from dr_lab.envs.tasks.humanoid import Humanoid
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class HumanoidDirection(Humanoid):
    """r = w_x (v_x cos θ + v_y sin θ) + r_h − w_u |u|² − min(w_c |f|², c_max), v being that of the centre of mass.

    θ is part of the context and is not seen. θ = 0 is Humanoid-v5 of gymnasium, but that r_h is also that of the step
    in which it falls. The observation is gymnasium's; the source's 376 columns are these 348 and 28 that are constant.

    Source: ProMP (Rothfuss et al. 2018), commit 93ae339, envs/mujoco_envs/humanoid_rand_direc_2d.py.

    Attributes: as `Humanoid`, and
        direction_range: of θ, lowest and highest, rad; nominal is the lowest.

    Raises:
        ConfigError: the range is none.
    """

    direction_range: Sequence[float]

    def __post_init__(self) -> None:
        super().__post_init__()
        require_range(self.direction_range, "env.task.direction_range", "rad")

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The direction, from the x axis on towards y."""
        low, high = self.direction_range
        return (Parameter("goal.direction", "rad", low, low, high),)

    def marker(self, fields: Fields) -> Array:
        """The centre of mass's x and y as MuJoCo's step leaves it."""
        return fields["subtree_com"][:, 0, :2]

    def reward(self, change: Change) -> Array:
        """Along the direction, alive, effort, contacts."""
        direction = change.values["goal.direction"]
        along = change.velocity[:, 0] * np.cos(direction) + change.velocity[:, 1] * np.sin(direction)
        return self.forward_weight * along + self.healthy_reward - self.costs(change)
