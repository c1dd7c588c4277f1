"""An encoder disc that is off its centre."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import slides
from dr_lab.effects.scalar_sensor_effect import measures_position
from dr_lab.effects.sensor_effect import SensorEffect
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class EncoderEccentricity(SensorEffect):
    """A graduated disc or a magnet whose centre lies beside the axis of rotation.

    reading = q + a sin q + b cos q; with an eccentricity e, at a radius r of the graduation, √(a² + b²) = e/r and
    atan2(b, a) is its direction (first order in e/r).

    Parameters (nominal = absent): sine a, cosine b [rad].
    Limits: positions of hinge joints whose encoder turns once with the joint. The velocity of the same encoder is
    (1 + a cos q − b sin q) q', but a reading of the velocity does not know the position: its channel is left as it
    is. Within a small range of motion a is a scale and b a bias.
    Source: HEIDENHAIN, Angle Encoders without Integral Bearing (eccentricity of the graduation: e/r).

    Attributes:
        largest: largest |a| and |b| [rad].
    """

    largest: float

    name: ClassVar[str] = "encoder_eccentricity"
    family: ClassVar[str] = "sensing"
    law: ClassVar[str] = "reading = q + a sin q + b cos q"
    fingerprint: ClassVar[str] = "residual of one period a turn, at every speed and load"
    confused_with: ClassVar[tuple[str, ...]] = ("sensor_scale", "sensor_bias")
    lacks: ClassVar[str] = "the eccentricity, which belongs to the measurement and not to the model"

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the hinge joints."""
        scalar = (site for site in super().sites(model) if not site.startswith("sensor."))
        return tuple(joint for joint in scalar if not slides(model, joint))

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """Both components."""
        del model, site, scales
        return tuple(Parameter(name, "rad", 0.0, -self.largest, self.largest) for name in ("sine", "cosine"))

    def reading(self, site: str, values: Mapping[str, Array], channel: str, read: Reading, begin: Array) -> Reading:
        """The position with an error of one period a turn."""
        del begin
        if not measures_position(channel, site):
            return read
        sine, cosine = values["sine"][..., None], values["cosine"][..., None]

        def eccentric(time: Array) -> Array:
            angle = read(time)
            return angle + sine * np.sin(angle) + cosine * np.cos(angle)

        return eccentric
