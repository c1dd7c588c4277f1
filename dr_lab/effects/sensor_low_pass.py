"""A filter between a motion and its record."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
from numpy.polynomial.laguerre import laggauss

from dr_lab.effects.effect import Scales
from dr_lab.effects.sensor_effect import SensorEffect, measures
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array

_NODES, _WEIGHTS = laggauss(2)  # 2 ∓ √2 and (2 ± √2)/4


@dataclass(frozen=True)
class SensorLowPass(SensorEffect):
    """An amplifier's or a driver's first-order filter.

    reading(t) = (1/tau) ∫₀^∞ exp(−s/tau) q(t − s) ds ≈ Σ wᵢ q(t − xᵢ tau), Gauss–Laguerre with two nodes: exact where
    the motion is cubic over some tau; a sine of frequency f is off by (2π f tau)⁴ of its size.

    Parameters (nominal = absent): tau ≥ 0 [s].
    Limits: joints (position and velocity) and sensors, vectors and orientations too; looks back by (2 + √2) tau, which
    must lie within the windows' margin. To slow motion it is a time offset of tau.
    Source: Abramowitz and Stegun, Handbook of Mathematical Functions (1964), 25.4.45.

    Attributes:
        longest: largest tau that is looked for at first [s].
    """

    longest: float

    name: ClassVar[str] = "sensor_low_pass"
    family: ClassVar[str] = "sensing"
    law: ClassVar[str] = "tau reading' + reading = q"
    fingerprint: ClassVar[str] = "residual proportional to velocity in one channel alone, less at the quick turns"
    confused_with: ClassVar[tuple[str, ...]] = ("sensor_time_offset", "actuator_delay", "actuator_lag")
    lacks: ClassVar[str] = "the filter, which belongs to the measurement and not to the model"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The time constant."""
        del model, site, scales
        return (Parameter("tau", "s", 0.0, 0.0, self.longest),)

    def limit(self, name: str, kept: float, margin: float) -> float:
        """As far as windows are simulated before their samples."""
        del name, kept
        return margin / float(_NODES[-1])

    def reading(self, site: str, values: Mapping[str, Array], channel: str, read: Reading, begin: Array) -> Reading:
        """Every channel of the site as its weighted past."""
        del begin
        if not measures(channel, site):
            return read
        near, far = (node * values["tau"] for node in _NODES)
        much, little = _WEIGHTS
        return lambda time: much * read(time - near) + little * read(time - far)
