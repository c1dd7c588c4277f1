"""A rotary arm swings its pole up."""

from dataclasses import dataclass

import numpy as np

from dr_lab.envs.task import Fields, Values
from dr_lab.envs.tasks.swing_up import SwingUp
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class Furuta(SwingUp):
    """Swing-up of the Furuta pendulum (Quanser Qube-Servo 2), as DiDoR (Brosseit et al., 2021) trains it.

    Source: SimuRLacra, Pyrado, environments/pysim/quanser_qube.py.
    """

    def observe(self, fields: Fields, values: Values) -> Array:
        """Sin θ, cos θ, sin α, cos α, θ', α' of arm and pole, shape (n, 6)."""
        del values
        qpos = fields["qpos"]
        angles = np.stack([np.sin(qpos), np.cos(qpos)], axis=2).reshape(len(qpos), -1)
        return np.concatenate([angles, fields["qvel"]], axis=1)
