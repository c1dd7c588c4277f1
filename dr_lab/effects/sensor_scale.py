"""A sensor that counts too much or too little."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.effect import Scales
from dr_lab.effects.scalar_sensor_effect import ScalarSensorEffect
from dr_lab.effects.sensor_effect import measures
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class SensorScale(ScalarSensorEffect):
    """A wrong gear ratio, a wrong number of counts per turn, a wrong sensitivity.

    reading = (1 + s) q about zero, for a joint's position and velocity, which come of the same encoder, or for one
    sensor.

    Parameters (nominal = absent): excess s [1].
    Limits: one number (no vector, no orientation). It scales about the zero of the reading; a zero that is wrong as
    well is a `sensor_bias` besides. If everything is linear in the motion, a drive with 1 + s times the force looks the
    same. A gear of another ratio r than the model's gives the joint r times the torque (`torque_scale`), and where the
    encoder sits at the motor also a reading r times as large (excess r − 1): these two are it. The start of a window is
    found from its reading by iterations that leave an error of s⁹; this bounds s.
    Source: Hollerbach, Khalil and Gautier, Springer Handbook of Robotics (2016), chapter 6 (gains of the sensors).

    Attributes:
        largest: largest |s| that is looked for at first.
        farthest: largest |s| to which that bound is moved where a fit runs into it.
    """

    largest: float
    farthest: float

    name: ClassVar[str] = "sensor_scale"
    family: ClassVar[str] = "sensing"
    law: ClassVar[str] = "reading = (1 + s) q"
    fingerprint: ClassVar[str] = "residual proportional to the reading; amplitudes are wrong while frequencies fit"
    confused_with: ClassVar[tuple[str, ...]] = ("torque_scale", "payload", "encoder_eccentricity")
    lacks: ClassVar[str] = "the sensor's scale, which belongs to the measurement and not to the model"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The excess."""
        del model, site, scales
        return (Parameter("excess", "1", 0.0, -self.largest, self.largest),)

    def limit(self, name: str, kept: float, margin: float) -> float:
        """As far as the windows' starts are found."""
        del name, kept, margin
        return self.farthest

    def reading(self, site: str, values: Mapping[str, Array], channel: str, read: Reading, begin: Array) -> Reading:
        """Every channel of the site, scaled."""
        del begin
        return (lambda time: (1.0 + values["excess"][..., None]) * read(time)) if measures(channel, site) else read
