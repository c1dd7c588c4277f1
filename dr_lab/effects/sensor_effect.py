"""What effects at a measured channel have in common."""

import mujoco

from dr_lab.effects.joint_effect import JointEffect
from dr_lab.physics.effect_parts import SensorTransform


class SensorEffect(JointEffect, SensorTransform):
    """An effect between a motion and its record: at a joint's encoder or at one sensor; the physics is untouched."""

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the hinge and slide joints, and ``sensor.<name>`` for every named sensor."""
        sensors = (model.sensor(i).name for i in range(model.nsensor))
        return (*super().sites(model), *(f"sensor.{name}" for name in sensors if name))


def measures(channel: str, site: str) -> bool:
    """Whether a channel is read at a site: a joint's position and velocity, or the sensor itself."""
    return channel in ((site,) if site.startswith("sensor.") else (f"{site}.position", f"{site}.velocity"))
