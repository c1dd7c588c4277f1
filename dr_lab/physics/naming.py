"""Names of elements of a model, also for those that have none."""

from collections.abc import Sequence
from typing import Any

import mujoco


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


def joints(model: mujoco.MjModel, kinds: Sequence[mujoco.mjtJoint]) -> tuple[str, ...]:
    """Names of the joints of the given kinds, in the model's order."""
    wanted = {int(k) for k in kinds}
    return tuple(model.joint(i).name for i in range(model.njnt) if int(model.jnt_type[i]) in wanted)
