"""A sensor whose zero wanders."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.effect import Scales
from dr_lab.effects.scalar_sensor_effect import ScalarSensorEffect, measures_position, range_of, unit_of
from dr_lab.effects.sensor_effect import measures
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class SensorDrift(ScalarSensorEffect):
    """Heat in a potentiometer or amplifier, a slipping belt, an encoder that loses counts one way.

    reading(t) = q(t) + r t with t on the log's clock; the velocity of the same encoder reads r too much.

    Parameters (nominal = absent): rate r [rad/s, slide: m/s, sensor: unit of the reading per s].
    Limits: one number (no vector, no orientation). The drift is zero at time zero of a log's clock and has the same
    rate in all logs; a zero that is wrong from the beginning is a `sensor_bias` besides.
    Source: Fraden, Handbook of Modern Sensors, 5th edition (2016), chapter 3 (drift).

    Attributes:
        factor: largest |r|, in units of the range read per s.
        joint_least: smallest range of a joint, for joints that hardly move [rad or m].
        sensor_range: range of a sensor [unit of the reading].
    """

    factor: float
    joint_least: float
    sensor_range: float

    name: ClassVar[str] = "sensor_drift"
    family: ClassVar[str] = "sensing"
    law: ClassVar[str] = "reading(t) = q(t) + r t"
    fingerprint: ClassVar[str] = "centre of the swings moves steadily with the time of the log"
    confused_with: ClassVar[tuple[str, ...]] = ("sensor_bias", "base_tilt")
    lacks: ClassVar[str] = "the drift, which belongs to the measurement and not to the model"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The rate."""
        high = self.factor * range_of(site, scales, self.joint_least, self.sensor_range)
        return (Parameter("rate", f"{unit_of(model, site)}/s", 0.0, -high, high),)

    def reading(self, site: str, values: Mapping[str, Array], channel: str, read: Reading, begin: Array) -> Reading:
        """Position or sensor with a shift that grows, the joint's velocity with its rate."""
        if not measures(channel, site):
            return read
        rate = values["rate"]
        if measures_position(channel, site):
            return lambda time: read(time) + (rate * (begin + time))[..., None]
        return lambda time: read(time) + rate[..., None]
