"""Combinations of bodies' inertias that the motion depends on: base parameters, from the equations of motion."""

from collections.abc import Sequence
from itertools import pairwise

import mujoco
import numpy as np

from dr_lab.physics.inertial import BodyInertial
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array

_ENTRIES = np.triu_indices(4)  # of a pseudo-inertia
_MOTIONS = 20  # twice as many as a body has numbers: a single joint may be all that feels it
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
        gravity compensation, equality constraints (MuJoCo softens them by the bodies' inertia), sensors of forces or of
        centres of mass, effects that edit a body. Of contacts the same is true, which the caller knows.
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
    objects = np.append(compiled.sensor_objtype, compiled.sensor_reftype)
    frames = (objects == int(mujoco.mjtObj.mjOBJ_BODY)).any()  # of a body's inertia
    told = np.isin(compiled.sensor_type, _TELL_INERTIA).any()
    return bool(fluid or compiled.neq or compiled.ngravcomp or frames or told)


def _felt(compiled: mujoco.MjModel, bodies: Sequence[int]) -> Array:
    """Orthonormal combinations of the entries of the bodies' pseudo-inertias that the joints feel, (k, 10 bodies)."""
    data, rng = mujoco.MjData(compiled), np.random.default_rng(_SEED)
    felt = list[Array]()
    for position, velocity, acceleration in rng.normal(size=(_MOTIONS, 3, compiled.nv)):
        data.qpos[:], data.qvel[:], data.qacc[:] = compiled.qpos0, velocity, acceleration
        mujoco.mj_integratePos(compiled, data.qpos, position, np.pi)
        mujoco.mj_kinematics(compiled, data)
        mujoco.mj_comPos(compiled, data)
        mujoco.mj_comVel(compiled, data)
        gravity = rng.normal(size=3)
        felt.append(np.concatenate([_force_by_entries(compiled, data, body, gravity) for body in bodies], axis=1))
    _, values, combinations = np.linalg.svd(np.concatenate(felt), full_matrices=False)
    return combinations[values > _ROUNDING * values[0]]


def _force_by_entries(model: mujoco.MjModel, data: mujoco.MjData, body: int, gravity: Array) -> Array:
    """What every joint must give for a body's motion, by the entries of its pseudo-inertia P, shape (nv, 10).

    A point x of the body moves by X (x, 1) for a unit of a joint's speed and accelerates by M (x, 1), with
    X = [[r]ₓ, p] and M = [[α]ₓ + [ω]ₓ[ω]ₓ, a − g], all in the body's axes. So the joint gives
    ∫ (X (x, 1))ᵀ M (x, 1) dm = tr(P Xᵀ M).
    """
    turned = data.xmat[body].reshape(3, 3).T
    ways, changes = np.zeros((2, 2, 3, model.nv))  # of the body's origin and axes, and their rates
    mujoco.mj_jacBody(model, data, *ways, body)
    mujoco.mj_jacDot(model, data, *changes, data.xpos[body], body)
    moves, turns = turned @ ways
    linear, angular = (ways @ data.qacc + changes @ data.qvel) @ turned.T
    whirl = _crossed(turns @ data.qvel)
    motion = np.column_stack([_crossed(angular) + whirl @ whirl, linear - turned @ gravity])
    moved = np.concatenate([_crossed(turns.T), moves.T[..., None]], axis=2)
    force = moved.transpose(0, 2, 1) @ motion
    both = force + force.transpose(0, 2, 1)
    both[:, range(4), range(4)] /= 2
    return both[:, *_ENTRIES]


def _crossed(vectors: Array) -> Array:
    """[v]ₓ of vectors, shape (…, 3) → (…, 3, 3)."""
    return -np.cross(vectors[..., None, :], np.eye(3))


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
