"""Names of elements of a model, also for those that have none."""

from collections.abc import Sequence
from typing import Any

import mujoco

from dr_lab.channel_names import is_sensor
from dr_lab.errors import ModelError


def name_elements(spec: mujoco.MjSpec) -> None:
    """Give every unnamed body, joint, actuator and sensor a name, ``<kind>_<place>`` with its place among its kind.

    Channels, commands, sites of effects and pictures refer to elements by name, and MJCF does not ask for one.

    Args:
        spec: edited in place.
    """
    kinds: dict[str, Sequence[Any]] = {
        "body": spec.bodies,
        "joint": spec.joints,
        "actuator": spec.actuators,
        "sensor": spec.sensors,
    }
    for kind, elements in kinds.items():
        taken = {element.name for element in elements}
        for place, element in enumerate(elements):
            if not element.name:
                name = f"{kind}_{place}"
                while name in taken:
                    name += "_"
                element.name = name
                taken.add(name)


def require_joints_apart(name: str, spec: mujoco.MjSpec) -> None:
    """Refuse a joint whose channels would pass for those of a sensor.

    Raises:
        ModelError: a joint of the model `name` is called ``sensor`` or ``sensor.<something>``.
    """
    for joint in spec.joints:
        if is_sensor(f"{joint.name}."):
            raise ModelError(
                f"Model {name!r}: joint {joint.name!r} cannot be told from a sensor, whose channel is called "
                "'sensor.<name>'. Rename the joint in the MJCF."
            )


def joints(model: mujoco.MjModel, kinds: Sequence[mujoco.mjtJoint]) -> tuple[str, ...]:
    """Names of the joints of the given kinds, in the model's order."""
    wanted = {int(k) for k in kinds}
    return tuple(model.joint(i).name for i in range(model.njnt) if int(model.jnt_type[i]) in wanted)
