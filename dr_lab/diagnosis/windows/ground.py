"""What never moves, below free bodies that may touch it, and how these rest on it."""

import contextlib
import warnings
from collections.abc import Callable, Iterator, Sequence
from copy import copy
from typing import NamedTuple

import mujoco
import numpy as np
from scipy.linalg import LinAlgWarning
from scipy.optimize import root, root_scalar

from dr_lab.diagnosis.windows.standing import locked
from dr_lab.diagnosis.windows.tangent import SINGULAR
from dr_lab.trajectory import Array

_NEAR = 1e-6  # m, how exactly the depth of a sinking machine is found at first
_MOST = 100  # steps; ten settle a rover on two wheels and a caster
_STEP = 1e-6  # squared step of slopes, in squared standard deviations: a micrometre
_FAR = 100.0  # standard deviations; no solver looks farther
_RESTS = 1e-3  # of gravity; slower, a contact's acceleration is none
_CARRIES = 0.5  # cosine of the angle between a contact and gravity; a steeper shape is a wall
_STANDS = 0.1  # of gravity; faster, the body tips over or slides; a slope's friction gives way by some hundredths

Pairs = frozenset[tuple[int, int]]


class Contacts(NamedTuple):
    """Shapes near each other that may carry one another, c of them, one of each moves and the other never does.

    Attributes:
        gaps: between them, m, shape (c,).
        rows: by what velocities they open, shape (c, nv).
        pairs: of geoms.
        apart: whether no two moving shapes of different bodies are near each other.
    """

    gaps: Array
    rows: Array
    pairs: Pairs
    apart: bool


class Ground:
    """What never moves, below free bodies.

    Args:
        model: compiled model.
        roots: the free bodies.
        footing: m, gap up to which two shapes are near each other.
    """

    def __init__(self, model: mujoco.MjModel, roots: Sequence[int], footing: float) -> None:
        self._near, self._rigid, self._footing = copy(model), locked(model), footing
        for margin in (self._near.geom_margin, self._near.body_margin, self._near.pair_margin):
            margin[:] = margin + footing
        self._near_data, self._data = mujoco.MjData(self._near), mujoco.MjData(self._rigid)
        self._roots, self._fixed = list(roots), model.body_weldid == 0
        self._pull = float(np.linalg.norm(model.opt.gravity))
        self._up = -model.opt.gravity / self._pull
        free = (model.jnt_type == mujoco.mjtJoint.mjJNT_FREE) & np.isin(model.jnt_bodyid, roots)
        self._linear = np.concatenate([adr + np.arange(3) for adr in model.jnt_dofadr[free]])

    def near(self, q: Array) -> Pairs | None:
        """Pairs of shapes that are near each other at positions; None where a body is near nothing, or near another."""
        found = self.contacts(q)
        bodies = {int(self._near.body_rootid[self._near.geom_bodyid[geom]]) for pair in found.pairs for geom in pair}
        return found.pairs if found.apart and bodies >= set(self._roots) else None

    def contacts(self, q: Array) -> Contacts:
        """The shapes near each other at positions (nq,)."""
        model, data = self._near, self._near_data
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_collision(model, data)
        gaps, rows, pairs, apart, jacobian = list[float](), list[Array](), set(), True, np.zeros((3, model.nv))
        for contact in data.contact:
            if min(contact.geom) < 0 or contact.dist > self._footing or abs(contact.frame[:3] @ self._up) < _CARRIES:
                continue
            one, other = (int(model.geom_bodyid[geom]) for geom in contact.geom)
            if not (self._fixed[one] or self._fixed[other]):
                apart &= bool(model.body_rootid[one] == model.body_rootid[other])
                continue
            sign, moving = (1.0, other) if self._fixed[one] else (-1.0, one)
            mujoco.mj_jac(model, data, jacobian, None, contact.pos, moving)
            gaps.append(contact.dist)
            rows.append(sign * contact.frame[:3] @ jacobian)
            pairs.add(tuple(sorted(int(geom) for geom in contact.geom)))
        return Contacts(np.array(gaps), np.reshape(rows, (len(rows), model.nv)), frozenset(pairs), apart)

    def settled(self, q: Array, place: Array, most: float) -> tuple[Array, Array] | None:
        """Positions at which contacts carry the bodies at rest, and the rows of these contacts; None where none do.

        What is near need not carry: the farthest is left out as long as the others do not come to rest nearby.

        Args:
            q: positions nearby, shape (nq,).
            place: by how much each may move, in proportion, shape (nv,).
            most: norm of the move at most, in units of `place`.
        """
        found = self.contacts(q)
        order = np.argsort(found.gaps, kind="stable")
        for count in range(len(order), 0, -1):
            by = self._rest(q, place, found.gaps[order[:count]], found.rows[order[:count]])
            if by is not None and np.linalg.norm(by / place) <= most:
                return self._moved(q, by), found.rows[order[:count]]
        return None

    def _rest(self, q: Array, place: Array, gaps: Array, rows: Array) -> Array | None:
        """The move (nv,) along some contacts at which they carry the bodies; None where it is not found."""
        _, sizes, parts = np.linalg.svd(rows * place, full_matrices=False)
        directions = place[:, None] * parts[sizes > SINGULAR * sizes.max()].T
        back = np.linalg.pinv(rows @ directions, rcond=SINGULAR)

        def sunk(depth: float) -> Array:
            return back @ (-gaps - depth)

        def rising(depth: float) -> float:
            return float(np.mean(rows @ self._acceleration(q, directions @ sunk(depth))))

        def pushed(by: Array) -> Array:
            return back @ rows @ self._acceleration(q, directions @ np.clip(by, -_FAR, _FAR))

        if not rising(0.0) < 0.0 < rising(self._footing):
            return None
        depth = root_scalar(rising, bracket=(0.0, self._footing), xtol=_NEAR).root
        moves = (directions @ by for by in _roots(pushed, sunk(depth)))
        return next((by for by in moves if self._rests(rows, self._acceleration(q, by))), None)

    def _rests(self, rows: Array, acceleration: Array) -> bool:
        """Whether contacts stay as they are, and the bodies where they are."""
        still = np.abs(rows @ acceleration).max() < _RESTS * self._pull
        return bool(still and np.abs(acceleration[self._linear]).max() < _STANDS * self._pull)

    def _acceleration(self, q: Array, by: Array) -> Array:
        """Accelerations at rest at positions that are moved, shape (nv,)."""
        self._data.qpos[:], self._data.qvel[:] = self._moved(q, by), 0.0
        mujoco.mj_forward(self._rigid, self._data)
        return self._data.qacc.copy()

    def _moved(self, q: Array, by: Array) -> Array:
        q = q.copy()
        mujoco.mj_integratePos(self._rigid, q, by, 1.0)
        return q


def _roots(force: Callable[[Array], Array], start: Array) -> Iterator[Array]:
    """Where a force may vanish, by two methods: contacts that come and go leave kinks, over which either may wander."""
    yield from _root(force, start, "anderson", maxiter=_MOST)
    yield from _root(force, start, "hybr", eps=_STEP)


def _root(force: Callable[[Array], Array], start: Array, method: str, **options: float) -> list[Array]:
    """Where one method ends; nothing where it breaks down on the way."""
    with warnings.catch_warnings(), contextlib.suppress(ArithmeticError, ValueError, np.linalg.LinAlgError):
        warnings.simplefilter("ignore", LinAlgWarning)
        warnings.simplefilter("ignore", RuntimeWarning)
        return [root(force, start, method=method, options=options).x]
    return []
