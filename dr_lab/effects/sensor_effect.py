"""What effects at a measured channel have in common."""

from collections.abc import Collection

import mujoco

from dr_lab.channel_names import is_sensor
from dr_lab.effects.joint_effect import JointEffect
from dr_lab.physics.effect_parts import SensorTransform
from dr_lab.physics.sensor_axes import sensor_axes


class SensorEffect(JointEffect, SensorTransform):
    """An effect between a motion and its record: at a joint's encoder or at one sensor; the physics is untouched."""

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the hinge and slide joints, ``sensor.<name>`` for every named sensor, and each axis of a vector."""
        sensors = (model.sensor(i).name for i in range(model.nsensor))
        named = (*(name for name in sensors if name), *sensor_axes(model))
        return (*super().sites(model), *(f"sensor.{name}" for name in named))

    def shown_by(self, site: str, channels: Collection[str]) -> bool:
        """Whether a sensor, or one axis of it, is in the logs."""
        return site in channels or not is_sensor(site)


def measures(channel: str, site: str) -> bool:
    """Whether a channel is read at a site: a joint's position and velocity, or the sensor itself."""
    return channel in ((site,) if is_sensor(site) else (f"{site}.position", f"{site}.velocity"))
