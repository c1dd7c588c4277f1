"""Closed chains: the equality constraints tell the state of joints that no channel measures from that of the others."""

from collections.abc import Sequence
from copy import copy
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space

from dr_lab.diagnosis.windows.tangent import SINGULAR, following
from dr_lab.trajectory import Array

Mask = NDArray[np.bool_]

CLOSING = (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD, mujoco.mjtEq.mjEQ_JOINT, mujoco.mjtEq.mjEQ_TENDON)
_OTHERS = (
    mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT | mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS
)
FIRM = 2.0  # time steps: the shortest time constant of a constraint that MuJoCo allows (option/refsafe)
_SOFT = 0.01  # s, half of MuJoCo's default: a chain whose time constant is longer comes apart under load
_STRIDE = 0.3  # rad or m of the way from the reference that is closed at a time, lest another assembly be met
_ITERATIONS = 20
_CLOSED = 1e-10  # rad or m, of a Gauss-Newton step
_FREE = 1e-3  # share of a velocity; below it nothing of it is free
_AHEAD = 1e-6  # s, over which the Jacobian's rate is a difference


class Closure(NamedTuple):
    """A state in which the unmeasured joints close the chains, those of the reference's assembly.

    Attributes:
        qpos: shape (nq,).
        qvel: shape (nv,).
        qacc: shape (nv,).
        slopes: of the velocities by the measured ones, shape (nv, nv).
        free: share of each velocity that nothing tells, 0 to 1, shape (nv,).
    """

    qpos: Array
    qvel: Array
    qacc: Array
    slopes: Array
    free: Array


def coupled(model: mujoco.MjModel) -> bool:
    """Whether equality constraints couple joints: no encoder shows their forces, which inverse dynamics needs."""
    return ClosedLoops(model, np.ones(model.nv, bool)).closes()


class ClosedLoops:
    """The closed chains of a model: its connect, weld, joint and tendon constraints c(q) = 0 with Jacobian J.

    Args:
        model: compiled model.
        known: degrees of freedom whose positions are measured, shape (nv,).
    """

    def __init__(self, model: mujoco.MjModel, known: Mask) -> None:
        self._model = copy(model)
        self._model.opt.disableflags |= int(_OTHERS)
        self._model.opt.jacobian = int(mujoco.mjtJacobian.mjJAC_DENSE)
        self._model.eq_active0[:] &= np.isin(self._model.eq_type, [int(kind) for kind in CLOSING])
        self._data = mujoco.MjData(self._model)
        self._known = known

    def closes(self) -> bool:
        """Whether a constraint holds some joint."""
        return bool(np.any(self.constraints(self._model.qpos0)[1]))

    def tells(self) -> bool:
        """Whether a constraint holds a joint that is not measured."""
        return bool(np.any(self.constraints(self._model.qpos0)[1][:, ~self._known]))

    def told(self) -> Mask:
        """Degrees of freedom that are measured, or that the constraints tell from the measured ones, shape (nv,)."""
        at_rest = np.zeros(self._model.nv)
        return self.closed(self._model.qpos0, at_rest, at_rest).free < _FREE

    def firm(self) -> bool:
        """Whether the constraints are so stiff that no chain comes apart."""
        constants = self._model.eq_solref[self._model.eq_active0.astype(bool), 0]
        return bool(np.all((constants > 0) & (constants <= _SOFT)))

    def closed(self, qpos: Array, qvel: Array, qacc: Array) -> Closure:
        """The state with its unmeasured joints u moved by Gauss-Newton on c, on the way of the measured ones m.

        J_u v_u = −J_m v_m and J_u a_u = −J_m a_m − J' v.
        """
        known, q = self._known, self._followed(qpos)
        _, jacobian = self.constraints(q)
        inverse = np.linalg.pinv(jacobian[:, ~known], rcond=SINGULAR)
        slopes, free = np.diag(known.astype(float)), np.zeros(len(known))
        slopes[np.ix_(~known, known)] = -inverse @ jacobian[:, known]
        free[~known] = np.sqrt(np.clip(1.0 - np.diag(inverse @ jacobian[:, ~known]), 0.0, 1.0))
        velocity, acceleration = slopes @ qvel, slopes @ qacc
        rate = (self.constraints(self._moved(q, _AHEAD * velocity))[1] - jacobian) @ velocity / _AHEAD
        acceleration[~known] -= inverse @ rate
        return Closure(q, velocity, acceleration, slopes, free)

    def nearest(self, qpos: Array, qvel: Array, std: Array) -> tuple[Array, Array]:
        """The state that is nearest to one, in standard deviations (2 nv,), of those with c = 0 and J v = 0."""
        place, speed = std.reshape(2, -1)
        q = self._solved(qpos, place)
        _, jacobian = self.constraints(q)
        back = np.linalg.lstsq(jacobian * speed, jacobian @ qvel, rcond=SINGULAR)[0]
        return q, qvel - speed * back

    def carried(self, q: Array, dofs: Sequence[int]) -> Array:
        """Velocities of all joints while one of some degrees of freedom moves by 1 and the others rest, (nv, n)."""
        _, jacobian = self.constraints(q)
        return following(null_space(jacobian, rcond=SINGULAR), dofs)

    def constraints(self, q: Array) -> tuple[Array, Array]:
        """Violations c, shape (r,), and their Jacobian, shape (r, nv)."""
        self._data.qpos[:] = q
        mujoco.mj_fwdPosition(self._model, self._data)
        return self._data.efc_pos.copy(), self._data.efc_J.reshape(-1, self._model.nv).copy()

    def _followed(self, target: Array) -> Array:
        """Positions with closed chains on the way of the measured joints from the reference to the target."""
        way = np.zeros(self._model.nv)
        mujoco.mj_differentiatePos(self._model, way, 1.0, self._model.qpos0, target)
        way[~self._known] = 0.0
        strides = max(1, int(np.ceil(np.abs(way).max() / _STRIDE)))
        q = self._model.qpos0.copy()
        for _ in range(strides):
            q = self._solved(self._moved(q, way / strides), (~self._known).astype(float))
        return q

    def _solved(self, q: Array, scale: Array) -> Array:
        """Positions with c = 0, each moved in proportion to a scale (nv,)."""
        for _ in range(_ITERATIONS):
            gap, jacobian = self.constraints(q)
            step = -scale * np.linalg.lstsq(jacobian * scale, gap, rcond=SINGULAR)[0]
            q = self._moved(q, step)
            if np.abs(step).max() < _CLOSED:
                break
        return q

    def _moved(self, q: Array, by: Array) -> Array:
        q = q.copy()
        mujoco.mj_integratePos(self._model, q, by, 1.0)
        return q
