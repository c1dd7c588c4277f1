"""Velocities as drives report them: differences of the encoder, smoothed."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from dr_lab.bounds import Positive
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class FilteredDifference:
    """v_k = a v_{k−1} + (1 − a) (q_k − q_{k−1}) / (t_k − t_{k−1}), a = exp(−2π corner / rate), from rest.

    Attributes:
        corner: of the filter, Hz.
    """

    corner: Positive

    def velocity(self, time: Array, reading: Array, rate: float) -> Array:
        """Velocity in rad/s or m/s, shape of `reading`.

        Args:
            time: of the samples, s, shape (n,).
            reading: what the encoders read, rad or m, shape (n, joints).
            rate: samples per second, Hz.
        """
        kept = float(np.exp(-2 * np.pi * self.corner / rate))
        rough = np.diff(reading, axis=0, prepend=reading[:1]) / np.diff(time, prepend=time[0] - 1.0 / rate)[:, None]
        return np.asarray(lfilter([1.0 - kept], [1.0, -kept], rough, axis=0))
