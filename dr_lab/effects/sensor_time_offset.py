"""Measurements that are stamped late or early."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class SensorTimeOffset(JointEffect):
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

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the hinge and slide joints, and ``sensor.<name>`` for every named sensor."""
        sensors = (model.sensor(i).name for i in range(model.nsensor))
        return (*super().sites(model), *(f"sensor.{name}" for name in sensors if name))

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The offset."""
        del model, site, scales
        return (Parameter("offset", "s", 0.0, -self.longest, self.longest),)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Nothing: the physics is untouched."""

    def output_delay(self, site: str, values: Mapping[str, float]) -> Mapping[str, float]:
        """The offset, on every channel of the site."""
        channels = (site,) if site.startswith("sensor.") else (f"{site}.position", f"{site}.velocity")
        return dict.fromkeys(channels, values["offset"])
