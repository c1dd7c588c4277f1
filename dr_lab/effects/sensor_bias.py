"""A sensor whose zero lies elsewhere."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.effect import Scales
from dr_lab.effects.scalar_sensor_effect import ScalarSensorEffect, measures_position, range_of, unit_of
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class SensorBias(ScalarSensorEffect):
    """An encoder that was not zeroed where the model has its zero, or a sensor with an offset.

    reading = q + b, for a joint's position or for one sensor; a joint's velocity does not show it. A joint whose zero
    lies elsewhere than in the model (MuJoCo's joint/ref) is the same, where no controller reads that encoder.

    Parameters (nominal = absent): bias b [rad, slide: m, sensor: unit of the reading].
    Limits: one number (no vector, no orientation), constant over all logs. A joint on whose position nothing depends
    (no gravity, spring or other joint) does not show it: the start states take it up. A position
    controller whose own encoder is off moves the joint as well: that is a bias and an offset of its commands besides.
    Source: Hollerbach, Khalil and Gautier, Springer Handbook of Robotics (2016), chapter 6 (joint offsets).

    Attributes:
        factor: largest |b|, in units of the range read.
        joint_least: smallest range of a joint, for joints that hardly move [rad or m].
        sensor_range: range of a sensor [unit of the reading].
    """

    factor: float
    joint_least: float
    sensor_range: float

    name: ClassVar[str] = "sensor_bias"
    family: ClassVar[str] = "sensing"
    law: ClassVar[str] = "reading = q + b"
    fingerprint: ClassVar[str] = "swings about a wrong centre; force residual as if gravity or a spring were turned"
    confused_with: ClassVar[tuple[str, ...]] = ("base_tilt", "constant_offset", "sensor_drift")
    lacks: ClassVar[str] = "the bias, which belongs to the measurement and not to the model"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The bias."""
        high = self.factor * range_of(site, scales, self.joint_least, self.sensor_range)
        return (Parameter("bias", unit_of(model, site), 0.0, -high, high),)

    def reading(self, site: str, values: Mapping[str, Array], channel: str, read: Reading, begin: Array) -> Reading:
        """Position or sensor, shifted."""
        del begin
        return (lambda time: read(time) + values["bias"][..., None]) if measures_position(channel, site) else read
