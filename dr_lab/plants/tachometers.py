"""Velocities that are measured, whatever the encoders read."""

from dataclasses import dataclass

import numpy as np

from dr_lab.bounds import NotNegative
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Tachometers:
    """One at the axis of each encoder, with white noise of its own.

    A filter that is hidden (`memory.SlowVelocity`) comes before the noise; what is wrong with an encoder, but for a
    delay, does not concern them.

    Attributes:
        std: rad/s.
    """

    std: NotNegative

    def measured(self, speed: Array, generator: np.random.Generator) -> Array:
        """What is read of angular velocities in rad/s, shape (n, joints)."""
        return speed + self.std * generator.standard_normal(speed.shape)
