"""A position over time, between the instants at which it is known, as encoders with a delay or a filter show it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from dr_lab.trajectory import Array

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)  # exact for what a cubic and a decay over a short step make


@dataclass(frozen=True)
class Path:
    """Positions along a course, joined by a cubic spline.

    Attributes:
        time: s, increasing, shape (m,).
        value: rad or m, shape (m,).
    """

    time: Array
    value: Array

    def at(self, instants: Array) -> Array:
        """Positions, rad or m, at instants, s."""
        return np.asarray(self._spline(instants))

    def rate(self, instants: Array) -> Array:
        """Velocities, rad/s or m/s, at instants, s."""
        return np.asarray(self._spline(instants, 1))

    def filtered(self, constant: float) -> "Path":
        """What a filter y' = (q − y) / constant shows of it, begun as if it had moved evenly before.

        Over a step h, exactly but for the integral, which has four nodes of Gauss and Legendre:
        y(t + h) = e^(−h/c) y(t) + ∫₀ʰ e^(−(h − s)/c) q(t + s) ds / c.
        """
        step = np.diff(self.time)
        inside = 0.5 * step[:, None] * (1 + _NODES)
        decay = np.exp(-(step[:, None] - inside) / constant) / constant
        added = 0.5 * step * ((decay * self.at(self.time[:-1, None] + inside)) @ _WEIGHTS)
        left, shown = np.exp(-step / constant), np.empty_like(self.value)
        shown[0] = self.value[0] - constant * float(self.rate(self.time[0]))
        for k, (kept, more) in enumerate(zip(left.tolist(), added.tolist(), strict=True)):
            shown[k + 1] = kept * shown[k] + more
        return Path(self.time, shown)

    @cached_property
    def _spline(self) -> CubicSpline:
        return CubicSpline(self.time, self.value)
