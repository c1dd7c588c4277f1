"""Measurements that are stamped late or early."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.effect import Scales
from dr_lab.effects.sensor_effect import SensorEffect, measures
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class SensorTimeOffset(SensorEffect):
    """A filter, a bus or another clock between a motion and its stamp.

    reading(t) = q(t − offset), for a joint's position and velocity or for one sensor; the physics is untouched.

    Parameters (nominal = absent): offset [s], positive where the reading is late.
    Limits: joints (channels ``<joint>.position`` and ``<joint>.velocity``) and sensors (``sensor.<name>``); an offset
    common to all channels is the same as an actuator delay where there is one command.
    Source: Furgale, Rehder and Siegwart, IROS 2013 (time offsets as continuous parameters).

    Attributes:
        longest: largest |offset| [s].
    """

    longest: float

    name: ClassVar[str] = "sensor_time_offset"
    family: ClassVar[str] = "sensing"
    law: ClassVar[str] = "reading(t) = q(t - offset)"
    fingerprint: ClassVar[str] = "residual proportional to velocity, in one channel alone"
    confused_with: ClassVar[tuple[str, ...]] = ("actuator_delay",)
    lacks: ClassVar[str] = "the offset, which belongs to the measurement and not to the model"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The offset."""
        del model, site, scales
        return (Parameter("offset", "s", 0.0, -self.longest, self.longest),)

    def limit(self, name: str, kept: float, margin: float) -> float:
        """As far as windows are simulated beyond their samples."""
        del name, kept
        return margin

    def reading(self, site: str, values: Mapping[str, Array], channel: str, read: Reading, begin: Array) -> Reading:
        """Every channel of the site as it was earlier."""
        del begin
        return (lambda time: read(time - values["offset"])) if measures(channel, site) else read
