"""What effects at a sensor that reports a single number have in common."""

import mujoco

from dr_lab.channel_names import is_sensor, sensor_of
from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import slides
from dr_lab.effects.sensor_effect import SensorEffect
from dr_lab.physics.sensor_axes import sensor_axes


class ScalarSensorEffect(SensorEffect):
    """An effect on one number: a joint's encoder, or a sensor with one value (no vector, no orientation)."""

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the hinge and slide joints, and ``sensor.<name>`` for every sensor, or axis, of one value."""
        return tuple(site for site in super().sites(model) if not is_sensor(site) or _is_scalar(model, site))


def measures_position(channel: str, site: str) -> bool:
    """Whether a channel is a joint's position read at the site, or the sensor itself."""
    return channel == (site if is_sensor(site) else f"{site}.position")


def unit_of(model: mujoco.MjModel, site: str) -> str:
    """Unit of what is read at a site: rad or m, ``reading`` for sensors, whose unit MuJoCo does not know."""
    if is_sensor(site):
        return "reading"
    return "m" if slides(model, site) else "rad"


def range_of(site: str, scales: Scales, joint_least: float, sensor: float) -> float:
    """Range of what is read at a site: a joint's in the logs, at least `joint_least`; `sensor` for sensors."""
    return sensor if is_sensor(site) else max(scales.position.get(site, 0.0), joint_least)


def _is_scalar(model: mujoco.MjModel, site: str) -> bool:
    name = sensor_of(site)
    return name in sensor_axes(model) or int(model.sensor(name).dim[0]) == 1
