"""A cart swings its pole up."""

from dataclasses import dataclass

import numpy as np

from dr_lab.envs.task import Fields, Values
from dr_lab.envs.tasks.swing_up import SwingUp
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class Cartpole(SwingUp):
    """Swing-up of the linear cart-pole (Quanser IP02, short pole), as DiDoR (Brosseit et al., 2021) trains it.

    Source: SimuRLacra, Pyrado, environments/pysim/quanser_cartpole.py.
    """

    def observe(self, fields: Fields, values: Values) -> Array:
        """x, sin θ, cos θ, x', θ' of cart and pole, shape (n, 5)."""
        del values
        cart, pole = fields["qpos"][:, :1], fields["qpos"][:, 1:]
        return np.concatenate([cart, np.sin(pole), np.cos(pole), fields["qvel"]], axis=1)
