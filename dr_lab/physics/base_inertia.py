"""Combinations of bodies' inertias that the motion depends on: base parameters, from the equations of motion."""

import copy
from collections.abc import Sequence
from itertools import pairwise

import mujoco
import numpy as np

from dr_lab.physics.inertial import BodyInertial
from dr_lab.physics.model import Model
from dr_lab.physics.pseudo_inertia import principal
from dr_lab.trajectory import Array

_ENTRIES = np.triu_indices(4)  # of a pseudo-inertia
_BALL = np.eye(4)  # pseudo-inertia of 1 kg with 1 m² about its centre; what stands in it drops out of differences
_CHANGE = 0.3  # of an entry of it, which leaves it a body that can exist
_MORE = 2  # times as many equations as there are numbers
_ROUNDING = 1e-9  # share of the combination that is felt most
_STEP = 1e-6  # widths of the bounds
_SEED = 0
_TELL_INERTIA = tuple(
    int(getattr(mujoco.mjtSensor, f"mjSENS_{name}"))
    for name in ("FORCE", "TORQUE", "SUBTREECOM", "SUBTREELINVEL", "SUBTREEANGMOM", "E_POTENTIAL", "E_KINETIC")
)


def base_directions(model: Model, z: Array) -> Array | None:
    """Directions of the free bodies' numbers that tell all of the motion's slopes by these numbers.

    The forces that a motion asks for are linear in the pseudo-inertias of the bodies, τ = Y(q, q̇, q̈) φ, and many
    combinations drop out of them, as a link's mass near its joint's axis does. What is felt of φ in random motions
    under random gravity spans the rest. A simulated motion depends on φ by τ alone. So with ∂φ/∂θ of the numbers θ and
    an orthonormal basis D (k, n) of what is felt, ∂r/∂θ = (∂r/∂θ Dᵀ) D: k simulations tell n slopes. An arm of seven
    joints has 45 combinations of 70 numbers.

    Source: Gautier and Khalil, IEEE Transactions on Robotics and Automation 6 (1990) 368 (base parameters).

    Args:
        model: its bodies that are free as a whole are meant.
        z: context, shape (n,).

    Returns:
        Orthonormal directions in widths of the bounds, shape (k, 10 bodies), by body in the order of
        `Model.inertials`; None where no body is free, or where more than the motion depends on inertia: fluids,
        gravity compensation, sensors of forces or of centres of mass, effects that edit a body.
    """
    bodies = model.inertials
    if not bodies or (model.effects and not model.bodies_apart):
        return None
    compiled = model.compile(z)
    if _feels_inertia_otherwise(compiled):
        return None
    ids = [compiled.body(each.body).id for each in bodies]
    slopes = _felt(compiled, ids) @ _entries_by_numbers(model, bodies, z)
    return np.linalg.qr(slopes.T)[0].T


def _feels_inertia_otherwise(compiled: mujoco.MjModel) -> bool:
    fluid = compiled.opt.density > 0 or compiled.opt.viscosity > 0
    frames = compiled.sensor_objtype == int(mujoco.mjtObj.mjOBJ_BODY)  # of a body's inertia
    return bool(fluid or compiled.ngravcomp or frames.any() or np.isin(compiled.sensor_type, _TELL_INERTIA).any())


def _felt(compiled: mujoco.MjModel, ids: Sequence[int]) -> Array:
    """Orthonormal combinations of the entries of the bodies' pseudo-inertias that the joints feel, (k, 10 bodies)."""
    model, rng, count = copy.copy(compiled), np.random.default_rng(_SEED), len(_ENTRIES[0])
    model.body_sameframe[:] = 0  # the bodies' frames are to be read
    motions = -(-_MORE * count * len(ids) // model.nv)
    states, gravities = rng.normal(size=(motions, 3, model.nv)), rng.normal(size=(motions, 3))
    for body in ids:
        _write(model, body, _BALL)
    plain, columns = _forces(model, states, gravities), list[Array]()
    for body in ids:
        for row, column in zip(*_ENTRIES, strict=True):
            changed = _BALL.copy()
            changed[row, column] += _CHANGE
            changed[column, row] = changed[row, column]
            _write(model, body, changed)
            columns.append(_forces(model, states, gravities) - plain)
        _write(model, body, _BALL)
    _, values, combinations = np.linalg.svd(np.stack(columns, axis=1), full_matrices=False)
    return combinations[values > _ROUNDING * values[0]]


def _write(model: mujoco.MjModel, body: int, pseudo: Array) -> None:
    mass = float(pseudo[3, 3])
    centre = pseudo[:3, 3] / mass
    moments, axes = principal((pseudo[:3, :3] - mass * np.outer(centre, centre))[None])
    model.body_mass[body], model.body_ipos[body] = mass, centre
    model.body_inertia[body], model.body_iquat[body] = moments[0], axes[0]


def _forces(model: mujoco.MjModel, states: Array, gravities: Array) -> Array:
    """What the motions ask for of every joint, one after the other; states as position, velocity, acceleration."""
    data, found = mujoco.MjData(model), np.empty((len(states), model.nv))
    for (position, velocity, acceleration), gravity, forces in zip(states, gravities, found, strict=True):
        model.opt.gravity[:] = gravity
        data.qpos[:] = model.qpos0
        mujoco.mj_integratePos(model, data.qpos, position, np.pi)
        data.qvel[:], data.qacc[:] = velocity, acceleration
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_comVel(model, data)
        mujoco.mj_rne(model, data, 1, forces)
    return found.ravel()


def _entries_by_numbers(model: Model, bodies: Sequence[BodyInertial], z: Array) -> Array:
    """Slopes of the entries by the numbers in widths of their bounds, one block a body, (10 bodies, 10 bodies)."""
    space, count = model.space, len(_ENTRIES[0])
    found = np.zeros((count * len(bodies), count * len(bodies)))
    for body, (first, last) in zip(bodies, pairwise(range(0, len(found) + 1, count)), strict=True):
        rows = [space.index(p.name) for p in body.parameters]
        steps = _STEP * np.diag(space.span[rows])
        ahead, behind = (body.shape.rooted(z[rows] + sign * steps).pseudo for sign in (1.0, -1.0))
        found[first:last, first:last] = ((ahead - behind) / (2 * _STEP))[:, *_ENTRIES].T
    return found
