"""Pictures of learned forces: what they are about the states of a log."""

from collections.abc import Mapping

import mujoco
import numpy as np

from dr_lab.effects.joint_effect import slides
from dr_lab.effects.learned_force import LearnedForce
from dr_lab.physics.radial_basis import Seen, features
from dr_lab.recorders.force_map import ForceMap
from dr_lab.recorders.training import ContextAxis
from dr_lab.trajectory import Array

_VALUES = 48  # of position and of velocity
_ROOM = 0.1  # beyond the outermost states, as a share of their range


def force_maps(
    model: mujoco.MjModel, forces: Mapping[str, tuple[LearnedForce, float]], seen: Seen
) -> dict[str, ForceMap]:
    """A picture of each force about the states of a log.

    Args:
        model: whose states they are.
        forces: learned, by joint, and the factor on each.
        seen: the states; those that are not finite are left out, and nothing is drawn where none is left.
    """
    finite = np.isfinite(seen.qpos).all(1) & np.isfinite(seen.qvel).all(1)
    if not finite.any():
        return {}
    seen = Seen(*(values[finite] for values in seen))
    return {joint: _force_map(model, joint, *each, seen) for joint, each in forces.items()}


def _force_map(model: mujoco.MjModel, joint: str, force: LearnedForce, factor: float, seen: Seen) -> ForceMap:
    q, v = int(model.joint(joint).qposadr[0]), int(model.joint(joint).dofadr[0])
    place = np.stack([seen.qpos[:, q], seen.qvel[:, v]], axis=1)
    ends = [_values(place[:, 0]), _values(place[:, 1])]
    cells = np.stack(np.meshgrid(*ends, indexing="ij"), axis=-1).reshape(-1, 2)
    width = np.ptp(np.stack([axis[[0, -1]] for axis in ends]), axis=1)
    away = (((cells[:, None] - place) / width) ** 2).sum(-1)
    nearest = away.argmin(1)
    about = Seen(*(values[nearest] for values in seen))
    about.qpos[:, q], about.qvel[:, v] = cells.T
    points = features(force.basis.inputs, model, about)
    value = np.where(force.basis.known(points) > 0.0, factor * force.at(points), np.nan)
    unit = "m" if slides(model, joint) else "rad"
    axes = (
        ContextAxis(f"position of {joint}", unit, ends[0]),
        ContextAxis(f"velocity of {joint}", f"{unit}/s", ends[1]),
    )
    return ForceMap(force.unit, *axes, value.reshape(_VALUES, _VALUES), place)


def _values(place: Array) -> Array:
    room = _ROOM * float(np.ptp(place)) or 1.0
    return np.linspace(place.min() - room, place.max() + room, _VALUES)
