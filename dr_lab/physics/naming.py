"""Names for elements of a model that have none."""

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
