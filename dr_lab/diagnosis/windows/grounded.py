"""Where a machine that rolls or slides begins a window: on the ground, sunk in as far as its weight presses it."""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace

import mujoco
import numpy as np
from scipy.optimize import root, root_scalar

from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.free_start import FreeBody
from dr_lab.diagnosis.windows.standing import locked
from dr_lab.diagnosis.windows.start_prior import StartPrior
from dr_lab.diagnosis.windows.tangent import SINGULAR, tangent
from dr_lab.trajectory import Array

_NEAR = 1e-6  # m, how exactly the depth of the sinking machine is found at first
_MOST = 100  # steps; ten settle a rover on two wheels and a caster
_RESTS = 1e-3  # of gravity; slower, a contact's acceleration is none


def grounded(
    prior: StartPrior, bodies: Sequence[FreeBody], model: mujoco.MjModel, settings: WindowSettings
) -> StartPrior:
    """The prior of free bodies that stay on the ground, whose starts stay there, too; as it is for all others.

    Sensors tell a place to a fraction of a millimetre. That is as much as a body sinks into its contacts. A start that
    is fitted there lifts a wheel off or doubles its load, so that the motion jumps with it, and no fit ends.

    1. Contacts are those of shapes of a body's tree, whose place is measured, with shapes that never move, where both
       are closer than `settings.footing`.
    2. The body stays on the ground if contacts hold the same number of directions in all windows, and no start moves
       along them by more than `settings.lifting` standard deviations. Limbs that walk and bodies that tumble do not.
    3. The place moves along the contacts until these carry the body at rest, its joints locked, and the velocity is
       the nearest one along the ground. No unknown of the start moves a contact.

    Args:
        prior: of all windows.
        bodies: the free bodies.
        model: compiled nominal model.
        settings: footing and lifting.
    """
    roots = [each.body for each in bodies if each.position]
    if prior.tangent is not None or not roots or not model.opt.gravity.any():
        return prior
    ground, (place, speed) = _Ground(model, roots, settings.footing), prior.std.reshape(2, -1)
    held = [ground.contacts(q)[1] for q in prior.qpos]
    ranks = {int(np.linalg.matrix_rank(rows * place, rtol=SINGULAR)) if len(rows) else 0 for rows in held}
    if len(ranks) > 1 or 0 in ranks:
        return prior
    back = [
        np.linalg.lstsq(rows * speed, rows @ v, rcond=SINGULAR)[0] for rows, v in zip(held, prior.qvel, strict=True)
    ]
    if np.linalg.norm(back, axis=1).max() > settings.lifting:
        return prior
    rest = [ground.settled(q, place) for q in prior.qpos]
    if any(q is None for q in rest):
        return prior
    directions = tangent(held, prior.std)
    return replace(
        prior,
        qpos=np.stack([q for q in rest if q is not None]),
        qvel=prior.qvel - speed * np.stack(back),
        std=np.ones(directions.basis.shape[2]),
        tangent=directions,
        grounded=True,
    )


class _Ground:
    """What never moves, below bodies that may touch it.

    Args:
        model: compiled model.
        roots: the free bodies.
        footing: m, gap up to which two shapes are in contact.
    """

    def __init__(self, model: mujoco.MjModel, roots: Sequence[int], footing: float) -> None:
        self._near, self._rigid, self._footing = copy(model), locked(model), footing
        for margin in (self._near.geom_margin, self._near.body_margin):
            margin[:] = np.maximum(margin, footing)
        self._near_data, self._data = mujoco.MjData(self._near), mujoco.MjData(self._rigid)
        self._fixed, self._own = model.body_weldid == 0, np.isin(model.body_rootid, roots)
        self._pull = float(np.linalg.norm(model.opt.gravity))

    def contacts(self, q: Array) -> tuple[Array, Array]:
        """Gaps at positions, shape (c,), and by what velocities they open, shape (c, nv)."""
        model, data = self._near, self._near_data
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_collision(model, data)
        gaps, rows, jacobian = list[float](), list[Array](), np.zeros((3, model.nv))
        for contact in data.contact:
            if min(contact.geom) < 0 or contact.dist > self._footing:
                continue
            one, other = (int(model.geom_bodyid[geom]) for geom in contact.geom)
            sign, moving = (1.0, other) if self._fixed[one] else (-1.0, one)
            if self._own[moving] and (self._fixed[one] or self._fixed[other]):
                mujoco.mj_jac(model, data, jacobian, None, contact.pos, moving)
                gaps.append(contact.dist)
                rows.append(sign * contact.frame[:3] @ jacobian)
        return np.array(gaps), np.reshape(rows, (len(rows), model.nv))

    def settled(self, q: Array, place: Array) -> Array | None:
        """Positions at which the contacts carry the bodies at rest; None where they do not.

        Args:
            q: positions nearby, shape (nq,).
            place: by how much each may move, in proportion, shape (nv,).
        """
        gaps, rows = self.contacts(q)
        _, sizes, parts = np.linalg.svd(rows * place, full_matrices=False)
        directions = place[:, None] * parts[sizes > SINGULAR * sizes.max()].T
        back = np.linalg.pinv(rows @ directions, rcond=SINGULAR)

        def sunk(depth: float) -> Array:
            return back @ (-gaps - depth)

        def rising(depth: float) -> float:
            return float(np.mean(rows @ self._acceleration(q, directions @ sunk(depth))))

        def pushed(by: Array) -> Array:
            return back @ rows @ self._acceleration(q, directions @ by)

        if not rising(0.0) < 0.0 < rising(self._footing):
            return None
        depth = root_scalar(rising, bracket=(0.0, self._footing), xtol=_NEAR).root
        # Contacts that come and go leave kinks, over which Newton's method wanders.
        found = directions @ root(pushed, sunk(depth), method="anderson", options={"maxiter": _MOST}).x
        rests = np.abs(rows @ self._acceleration(q, found)).max() < _RESTS * self._pull
        return self._moved(q, found) if rests else None

    def _acceleration(self, q: Array, by: Array) -> Array:
        """Accelerations at rest at positions that are moved, shape (nv,)."""
        self._data.qpos[:], self._data.qvel[:] = self._moved(q, by), 0.0
        mujoco.mj_forward(self._rigid, self._data)
        return self._data.qacc.copy()

    def _moved(self, q: Array, by: Array) -> Array:
        q = q.copy()
        mujoco.mj_integratePos(self._rigid, q, by, 1.0)
        return q
