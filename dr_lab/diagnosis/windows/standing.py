"""Where a body that stands or walks on its limbs begins a window: on the ground, which its feet do not slide over."""

from copy import copy
from itertools import product

import mujoco
import numpy as np
from scipy.optimize import root_scalar
from scipy.stats import median_abs_deviation, norm

from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.free_start import FreeBody
from dr_lab.diagnosis.windows.start_prior import StartPrior
from dr_lab.trajectory import Array

_FAR, _NEAR = 10.0, 1e-5  # m: how far the ground is looked for, and how exactly it is met
_LOCKED = 1e6  # m²; armature of a locked joint for each kilogram of the machine
_UPRIGHT = 0.5  # share of an axis that gravity has
_LOWERED = 20  # times at most; a plane takes one, a slope or a field of heights some more


def stand(prior: StartPrior, body: FreeBody, model: mujoco.MjModel, settings: WindowSettings) -> None:
    """Put a body whose place nothing measures onto its feet, and move it as the standing ones do not slide.

    1. Feet are those shapes of its limbs that may touch something that never moves. What lies on a shape of its own, as
       a box does, or has no gravity, is left where it is.
    2. The body is lowered along gravity until the lowest foot touches. Those within `settings.footing` of the ground
       stand.
    3. Its velocity is the median of −J q' over their lowest points, J being the Jacobian and q' the velocities of the
       joints and the body's rotation.
    4. It sinks until the contacts carry it as if its joints were locked.

    The height's standard deviation is the footing. The velocity's is `prior_scale` times the scatter of the feet that
    stand, told by the median of its size, where two or more do; it is at least the footing in a window's length.
    """
    pull = float(np.linalg.norm(model.opt.gravity))
    pairs = _feet(model, body.body)
    if pull == 0.0 or not pairs:
        return
    up, scatter, stands = -model.opt.gravity / pull, list[Array](), False
    data, place, speed = mujoco.MjData(model), slice(body.address, body.address + 3), slice(body.dof, body.dof + 3)
    rigid = locked(model)
    for qpos, qvel in zip(prior.qpos, prior.qvel, strict=True):
        data.qpos[:] = qpos
        if not _lowered(model, data, pairs, data.qpos[place], up):
            continue
        stands, slips = True, _slips(model, data, pairs, qvel, settings.footing)
        qvel[speed] = -np.median(slips, axis=0)
        qpos[place] = data.qpos[place] - _sag(rigid, data.qpos, body, up, settings.footing) * up
        if len(slips) > 1:
            scatter.append(slips - np.median(slips, axis=0))
    if stands:
        prior.std[body.dof + np.flatnonzero(np.abs(up) > _UPRIGHT)] = settings.footing
    if scatter:
        wrong = median_abs_deviation(np.concatenate(scatter), scale=float(norm.ppf(0.75)))
        std = np.maximum(settings.prior_scale * wrong, settings.footing / settings.length)
        prior.std[model.nv + speed.start : model.nv + speed.stop] = std


def _feet(model: mujoco.MjModel, body: int) -> list[tuple[int, int]]:
    """Pairs of a shape of the body's limbs and a shape that never moves which may touch each other."""
    fixed = np.flatnonzero(model.body_weldid[model.geom_bodyid] == 0)
    limbs = [
        geom
        for geom in np.flatnonzero(model.body_rootid[model.geom_bodyid] == body)
        if model.body_weldid[model.geom_bodyid[geom]] != body
    ]
    kinds, others = model.geom_contype, model.geom_conaffinity
    return [
        (int(limb), int(ground))
        for limb, ground in product(limbs, fixed)
        if kinds[limb] & others[ground] or kinds[ground] & others[limb]
    ]


def _lowered(model: mujoco.MjModel, data: mujoco.MjData, pairs: list[tuple[int, int]], place: Array, up: Array) -> bool:
    """Whether the ground was met by moving the body's place, a view of qpos, along gravity."""
    for _ in range(_LOWERED):
        mujoco.mj_kinematics(model, data)
        distance = min(mujoco.mj_geomDistance(model, data, *pair, _FAR, None) for pair in pairs)
        if distance >= _FAR:
            return False
        if abs(distance) < _NEAR:
            return True
        place -= distance * up
    return False


def locked(model: mujoco.MjModel) -> mujoco.MjModel:
    """The model with joints that hardly give way, free ones as they are."""
    rigid = copy(model)
    limbs = np.isin(rigid.dof_jntid, np.flatnonzero(rigid.jnt_type != mujoco.mjtJoint.mjJNT_FREE))
    rigid.dof_armature[limbs] = _LOCKED * model.body_mass.sum()
    return rigid


def _sag(rigid: mujoco.MjModel, qpos: Array, body: FreeBody, up: Array, most: float) -> float:
    """How far the body sinks below where its lowest foot touches until it rests, at most so far."""
    data = mujoco.MjData(rigid)

    def rising(depth: float) -> float:
        data.qpos[:], data.qvel[:] = qpos, 0.0
        data.qpos[body.address : body.address + 3] -= depth * up
        mujoco.mj_forward(rigid, data)
        return float(up @ data.qacc[body.dof : body.dof + 3])

    return root_scalar(rising, bracket=(0.0, most), xtol=_NEAR).root if rising(0.0) < 0.0 < rising(most) else 0.0


def _slips(
    model: mujoco.MjModel, data: mujoco.MjData, pairs: list[tuple[int, int]], qvel: Array, footing: float
) -> Array:
    """Velocities of the lowest points of the feet that stand, while the body turns but does not move, (feet, 3)."""
    mujoco.mj_comPos(model, data)
    jacobian, segment, found = np.zeros((3, model.nv)), np.zeros(6), list[Array]()
    for limb, ground in pairs:
        if mujoco.mj_geomDistance(model, data, limb, ground, _FAR, segment) < footing:
            mujoco.mj_jac(model, data, jacobian, None, segment[:3], int(model.geom_bodyid[limb]))
            found.append(jacobian @ qvel)
    return np.array(found)
