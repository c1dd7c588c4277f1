"""An encoder whose error repeats with its turns: a disc that is off its centre."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.channel_names import is_sensor
from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import slides
from dr_lab.effects.periodic import PERIODS, Periodic, half_a_period
from dr_lab.effects.scalar_sensor_effect import measures_position
from dr_lab.effects.sensor_effect import SensorEffect
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class EncoderEccentricity(SensorEffect, Periodic):
    """A graduated disc or a magnet whose centre lies beside the axis of rotation.

    The disc stands at n q and reads n q + a sin(n q) + b cos(n q), so that reading = q + (a sin(n q) + b cos(n q))/n;
    with an eccentricity e, at a radius r of the graduation, √(a² + b²) = e/r and atan2(b, a) is its direction (first
    order in e/r). n = 1 is a disc that turns with the joint, another n one behind a gear or at the motor; along a slide
    n = 2π over the lead of a screw or the travel of a belt's pulley.

    Parameters (nominal = absent): sine a, cosine b [rad of the disc]; periods n [1/turn, slide: rad/m], which acts only
    where a or b is not zero and is none where the user gives it.
    Limits: positions of hinge and slide joints. The velocity of the same encoder is (1 + n a cos(n q) − n b sin(n q))
    q', but a reading of the velocity does not know the position: its channel is left as it is. Within a small range of
    motion a is a scale and b a bias. The reading's slope is 1 to within √(a² + b²): below 1, which the bounds keep at
    every n, a reading tells one position, where windows begin.
    Source: HEIDENHAIN, Angle Encoders without Integral Bearing (eccentricity of the graduation: e/r).

    Attributes:
        largest: largest |a| and |b| [rad].
    """

    largest: float

    name: ClassVar[str] = "encoder_eccentricity"
    family: ClassVar[str] = "sensing"
    law: ClassVar[str] = "reading = q + (a sin(n q) + b cos(n q))/n"
    fingerprint: ClassVar[str] = "residual that repeats once a turn, or n times, at every speed and load"
    limited: ClassVar[tuple[str, ...]] = ("sine", "cosine")  # a reading that turns back tells no position
    confused_with: ClassVar[tuple[str, ...]] = ("sensor_scale", "sensor_bias", "cogging")
    lacks: ClassVar[str] = "the eccentricity, which belongs to the measurement and not to the model"

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the hinge and slide joints."""
        return tuple(site for site in super().sites(model) if not is_sensor(site))

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """Both components and the number of periods."""
        # a disc that turns with the joint may be anywhere
        fewest = half_a_period(site, scales) if slides(model, site) else 1.0
        phases = (Parameter(name, "rad", 0.0, -self.largest, self.largest) for name in ("sine", "cosine"))
        return (*phases, *self.number(model, site, fewest, np.inf))

    def reading(self, site: str, values: Mapping[str, Array], channel: str, read: Reading, begin: Array) -> Reading:
        """The position with an error that repeats."""
        del begin
        if not measures_position(channel, site):
            return read
        sine, cosine = values["sine"][..., None], values["cosine"][..., None]
        periods = values.get(PERIODS, np.full((1, 1, 1), self.periods))[..., None]

        def eccentric(time: Array) -> Array:
            position = read(time)
            disc = periods * position
            return position + (sine * np.sin(disc) + cosine * np.cos(disc)) / periods

        return eccentric
