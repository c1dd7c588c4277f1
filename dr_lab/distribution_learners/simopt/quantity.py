"""What can be measured of a target and of its model alike."""

from collections.abc import Mapping
from dataclasses import dataclass

import mujoco

_WAYS = {int(mujoco.mjtJoint.mjJNT_HINGE): "rad", int(mujoco.mjtJoint.mjJNT_SLIDE): "m"}


@dataclass(frozen=True)
class Quantity:
    """A number of every control step.

    Attributes:
        name: ``<joint>.position``, ``<joint>.velocity``, or what the task calls it.
        unit: SI unit.
        key: of what an episode holds after a step, as `collectors.play.play` gives it.
        column: there.
    """

    name: str
    unit: str
    key: str
    column: int


def quantities(compiled: mujoco.MjModel, seen: Mapping[str, int]) -> dict[str, Quantity]:
    """All quantities of a machine, by name: positions and velocities of hinges and slides, and what a task sees.

    Args:
        compiled: the machine.
        seen: `Task.measured`: columns of the observation by name, places in m.
    """
    joints = [compiled.joint(index) for index in range(compiled.njnt)]
    simple = [(joint, _WAYS[int(joint.type[0])]) for joint in joints if int(joint.type[0]) in _WAYS]
    places = [Quantity(f"{each.name}.position", way, "qpos", int(each.qposadr[0])) for each, way in simple]
    speeds = [Quantity(f"{each.name}.velocity", f"{way}/s", "qvel", int(each.dofadr[0])) for each, way in simple]
    sights = [Quantity(name, "m", "observation", column) for name, column in seen.items()]
    return {each.name: each for each in (*places, *speeds, *sights)}
