"""Where a load sits on a link."""

from typing import Any

import mujoco
import numpy as np

from dr_lab.effects.body_effect import body_of
from dr_lab.errors import ModelError
from dr_lab.physics.inertias import require_apart
from dr_lab.physics.pseudo_inertia import Rooted, principal
from dr_lab.trajectory import Array


def loaded(spec: mujoco.MjSpec, name: str) -> Any:  # noqa: ANN401 (MjsBody)
    """A body of a spec that can carry a load with an inertia of its own.

    Raises:
        UnknownNameError: there is no such body.
        ModelError: the compiler would overwrite the load's inertia, or change other bodies with it.
    """
    if spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE:
        raise ModelError(
            'A payload needs <inertial>, which inertiafromgeom="true" ignores. Set the compiler\'s inertiafromgeom to '
            '"auto".'
        )
    require_apart(spec, name)
    return body_of(spec, name)


def mounted(spec: mujoco.MjSpec, body: str, name: str, origin: Array, axes: Array) -> None:
    """Fix a body without mass to another one.

    Args:
        spec: the caller's own.
        body: name of what carries it.
        name: its own name.
        origin: of its frame in the other's, shape (3,), m.
        axes: of its frame in the other's, as columns, shape (3, 3).

    Raises:
        UnknownNameError: there is no such body.
        ModelError: the compiler would overwrite its inertia.
    """
    turned = np.zeros(4)
    mujoco.mju_mat2Quat(turned, axes.flatten())
    load = loaded(spec, body).add_body(name=name, pos=origin, quat=turned)
    load.explicitinertial, load.mass, load.ipos, load.inertia = True, 0.0, np.zeros(3), np.zeros(3)


def become(spec: mujoco.MjSpec, name: str, body: Rooted) -> None:
    """Give a mounted load the mass, the centre and the inertia of a body, the first of some."""
    load = spec.body(name)
    load.mass, load.ipos = float(body.mass[0]), body.centre[0]
    load.inertia, load.iquat = principal(body.second[0])


def load_frame(model: mujoco.MjModel, body: int) -> tuple[Array, Array, float]:
    """Anchor, axes and length of a link: anchor of its last joint (3,), columns (3, 3), and m.

    The first axis leads across the hinge's axis to the centre of mass, whose distance is the length; the last axis is
    the hinge's. Without a hinge the last two are some directions across the first.
    """
    anchor, lever = lever_of(model, body)
    length = float(np.linalg.norm(lever))
    first = lever / length if length else across(model, body)
    axis = hinge_axis(model, body)
    last = axis if axis.any() else np.cross(first, np.eye(3)[np.argmin(np.abs(first))])
    last = np.asarray(last / np.linalg.norm(last), dtype=float)
    return anchor, np.stack([first, np.asarray(np.cross(last, first), dtype=float), last], axis=1), length


def link_length(model: mujoco.MjModel, body: int) -> float:
    """Distance of a link's centre from its hinge's axis, or its radius of gyration if that is larger, m."""
    own = np.sqrt(model.body_inertia[body].max() / max(model.body_mass[body], mujoco.mjMINVAL))
    return max(float(np.linalg.norm(lever_of(model, body)[1])), float(own))


def hinge_axis(model: mujoco.MjModel, body: int) -> Array:
    """Axis of the body's last hinge in the body's frame, zero if it has none."""
    first = int(model.body_jntadr[body])
    rows = range(first, first + int(model.body_jntnum[body]))
    hinges = [row for row in rows if int(model.jnt_type[row]) == int(mujoco.mjtJoint.mjJNT_HINGE)]
    return model.jnt_axis[hinges[-1]].copy() if hinges else np.zeros(3)


def lever_of(model: mujoco.MjModel, body: int) -> tuple[Array, Array]:
    """Anchor of the body's last joint, and the vector across its hinge's axis from there to the centre of mass."""
    joints = int(model.body_jntnum[body])
    anchor = model.jnt_pos[int(model.body_jntadr[body]) + joints - 1].copy() if joints else np.zeros(3)
    axis, centre = hinge_axis(model, body), model.body_ipos[body] - anchor
    lever = centre - axis * (axis @ centre)
    rounding = np.finfo(float).eps ** 0.5 * max(float(np.linalg.norm(centre)), model.stat.extent)
    return anchor, lever if np.linalg.norm(lever) > rounding else np.zeros(3)


def across(model: mujoco.MjModel, body: int) -> Array:
    """Unit vector across the body's hinge axis."""
    axis = hinge_axis(model, body)
    across = np.asarray(np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))]), dtype=float)
    length = float(np.linalg.norm(across))
    return across / length if length else np.array([1.0, 0.0, 0.0])
