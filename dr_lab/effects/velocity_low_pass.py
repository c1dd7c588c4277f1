"""A filter between a joint's motion and the velocity that a drive reports of it."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect
from dr_lab.physics.effect_parts import SensorTransform
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class VelocityLowPass(JointEffect, SensorTransform):
    """A drive that makes velocities of encoder counts, as differences over a time or behind a filter.

    reading(t) = (1/tau) ∫₀^∞ exp(−s/tau) q̇(t − s) ds ≈ ½ q̇(t) + ½ q̇(t − 2 tau): two nodes of equal weight with the
    filter's mean tau and variance tau², exact where the velocity is quadratic over some tau. A difference
    (q(t) − q(t − T)) / T comes T/2 late; behind both, tau is T/2 and the filter's own. The position is untouched.

    Parameters (nominal = absent): tau ≥ 0 [s].
    Limits: joints of which both position and velocity are logged, else it is `sensor_low_pass` or nothing. Looks back
    by 2 tau, which must lie within the windows' margin. A velocity that was made of the logged positions themselves is
    left out before (`measurements.derived_velocity`).
    Source: Rosenblueth, PNAS 72 (1975) 3812 (two nodes at mean ± standard deviation).

    Attributes:
        longest: largest tau that is looked for at first [s].
    """

    longest: float

    name: ClassVar[str] = "velocity_low_pass"
    family: ClassVar[str] = "sensing"
    law: ClassVar[str] = "tau reading' + reading = q'"
    fingerprint: ClassVar[str] = "residual of the velocity alone proportional to acceleration; the position fits"
    confused_with: ClassVar[tuple[str, ...]] = ("sensor_time_offset", "sensor_low_pass")
    lacks: ClassVar[str] = "the filter, which belongs to the measurement and not to the model"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The time constant."""
        del model, site, scales
        return (Parameter("tau", "s", 0.0, 0.0, self.longest),)

    def limit(self, name: str, kept: float, margin: float) -> float:
        """As far as windows are simulated before their samples."""
        del name, kept
        return margin / 2.0

    def shown_by(self, site: str, channels: Collection[str]) -> bool:
        """Whether the logs hold the joint's position beside its velocity."""
        return {f"{site}.position", f"{site}.velocity"} <= set(channels)

    def reading(self, site: str, values: Mapping[str, Array], channel: str, read: Reading, begin: Array) -> Reading:
        """The velocity as the mean of now and earlier."""
        del begin
        if channel != f"{site}.velocity":
            return read
        return lambda time: 0.5 * (read(time) + read(time - 2.0 * values["tau"]))
