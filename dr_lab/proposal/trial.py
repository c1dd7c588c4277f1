"""A reading of the logs, tried by the robot's equation of motion: what the joints needed, and which series gave it.

The force that inverse dynamics asks for is compared with each command in weak form (`diagnosis.faults.equation_error`),
beside what may brake: viscous and dry friction and a rotor's inertia, none of them negative, and a constant.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np
from scipy.optimize import nnls

from dr_lab.diagnosis.faults.equation_error import Demand, actuation, demand
from dr_lab.diagnosis.faults.smoothed_motion import Motion
from dr_lab.proposal.grid import Grid, Path
from dr_lab.trajectory import Array

SLOW = 0.05  # of the root mean square speed: below it, friction's direction is undecided
_APART = 1e-9  # share of a column that the free ones do not hold, for it to count


@dataclass(frozen=True)
class Reading:
    """How a joint's position follows from a series: factor · raw + offset.

    Attributes:
        series: its place among the candidates.
        factor: sign and unit.
        offset: rad or m.
    """

    series: int
    factor: float
    offset: float = 0.0


@dataclass(frozen=True)
class Given:
    """What a series gives a joint.

    Attributes:
        series: its place among the drives.
        lag: s by which it acts late.
        gain: joint force per unit of the raw number, N·m or N.
        stiffness: of a servo towards the series as a position, N·m/rad or N/m; 0 where the series is a force.
        damping: of that servo, N·m·s/rad or N·s/m.
        constant: force that acts beside the series, N·m or N.
        left: squares that remain, over those of the joint's inertial and gravitational forces, or of what it needs.
        gain_std: standard deviation of `gain` by what remains, where the series is a force.
        rotor: inertia that acts beside the model's, where the series is a force, kg·m² or kg.
    """

    series: int
    lag: float
    gain: float
    stiffness: float
    damping: float
    constant: float
    left: float
    gain_std: float = 0.0
    rotor: float = 0.0


@dataclass(frozen=True)
class Outcome:
    """A reading, tried.

    Attributes:
        idle: squares that remain without any command, by degree of freedom, shape (nv,); relative as `Given.left`.
        given: what each series gives each degree of freedom that may be driven, best first.
        need: force that the motion asks for beside what actuators give at control 0, shape (w, nv).
        whole: force that it asks for with that, shape (w, nv).
        speed: shape (n, nv), for bounds of damping.
        size: squares that `idle` and `Given.left` are shares of, shape (nv,), N²·m² or N².
    """

    idle: Array
    given: tuple[tuple[Given, ...], ...]
    need: Array
    whole: Array
    speed: Array
    size: Array

    @property
    def left(self) -> Array:
        """Squares that remain by degree of freedom, each with the series that explains it best, shape (nv,)."""
        return np.array(
            [min([idle, *(each.left for each in g)]) for idle, g in zip(self.idle, self.given, strict=True)]
        )

    @property
    def total(self) -> float:
        """Mean over the degrees of freedom; a share above 1 says no more than 1 does."""
        return float(np.minimum(self.left, 1.0).mean())


@dataclass(frozen=True)
class Trial:
    """A robot and the series of its logs.

    Attributes:
        model: compiled; every joint is a hinge or slide.
        grid: test functions.
        candidates: what may be positions.
        drives: what may be commands: by lag, numbers on the grid, shape (n,).
        lags: s, of `drives`.
        servos: whether each drive may be the reference of a servo that the model lacks.
        driven: degrees of freedom that may be driven.
        biased: whether actuators give force at control 0.
        rates: places of candidates that are velocities, integrated.
        integrals: of `drives`, from the beginning of every log on; empty where no actuator integrates its control.
        integrated: degrees of freedom whose actuators integrate their control, from an unknown value on.
        barred: which drives command no force at which degree of freedom, as their names say: (drive, dof).
        sprung: whether a spring may act beside what brakes.
    """

    model: mujoco.MjModel
    grid: Grid
    candidates: tuple[Path, ...]
    drives: tuple[tuple[Array, ...], ...]
    lags: Sequence[float]
    servos: tuple[bool, ...]
    driven: tuple[bool, ...]
    biased: bool
    rates: frozenset[int] = frozenset()
    integrals: tuple[tuple[Array, ...], ...] = ()
    integrated: frozenset[int] = frozenset()
    barred: frozenset[tuple[int, int]] = frozenset()
    sprung: bool = False

    def motion(self, readings: Sequence[Reading]) -> Motion:
        """The motion that a reading makes of the candidates, joints in the model's order."""
        used = [(self.candidates[r.series], r) for r in readings]
        qpos, qvel, qacc = (
            np.stack([r.factor * getattr(path, name) for path, r in used], axis=1)
            for name in ("value", "slope", "curvature")
        )
        qpos = qpos + [r.offset for r in readings]
        log, known = np.repeat(self.grid.log, self.grid.time.shape[1]), np.ones(len(qpos), bool)
        return Motion(log, self.grid.time.ravel(), qpos, qvel, qacc, known, self.grid.step)

    def __call__(self, readings: Sequence[Reading]) -> Outcome:
        """Try a reading."""
        motion, weak = self.motion(readings), self.grid.weak
        needed = demand(self.model, motion)
        force = needed.force
        if self.biased:
            controls = np.zeros((len(motion), self.model.nu))
            force = force - actuation(self.model, motion, controls).idle
        need = weak.project(force)
        size = np.maximum(self._size(needed), ((need - need.mean(0)) ** 2).sum(0))
        brakes = [_brakes(weak.project, motion, dof, spring=self.sprung) for dof in range(self.model.nv)]
        constant = np.ones((len(weak), 1))
        idle = np.array([_fit(need[:, j], constant, b)[2] for j, b in enumerate(brakes)]) / size
        given = tuple(
            self._given(
                _Joint(
                    dof=j,
                    need=need[:, j],
                    brakes=brakes[j],
                    place=weak.project(motion.qpos[:, [j]])[:, 0],
                    constants=self._of_each_log if j in self.integrated else constant,
                    size=float(size[j]),
                )
            )
            if driven
            else ()
            for j, driven in enumerate(self.driven)
        )
        return Outcome(idle, given, need, weak.project(needed.force), motion.qvel, size)

    @property
    def _of_each_log(self) -> Array:
        """Constants that differ between logs, shape (w, logs)."""
        return (self.grid.log[:, None] == np.unique(self.grid.log)).astype(np.float64)

    def _size(self, needed: Demand) -> Array:
        """Squares of the joint's forces about their mean, which a constant would explain."""
        weak = self.grid.weak
        parts = [weak.project(part) for part in (needed.inertia, needed.gravity)]
        return np.maximum(sum(((part - part.mean(0)) ** 2).sum(0) for part in parts), np.finfo(float).tiny)

    def _given(self, joint: "_Joint") -> tuple[Given, ...]:
        """What each series gives, at the lag at which it leaves least."""
        found = []
        for k, late in enumerate(self.integrals if joint.dof in self.integrated else self.drives):
            if (k, joint.dof) in self.barred:
                continue
            columns = [self.grid.weak.project(values[:, None])[:, 0] for values in late]
            forces = [_as_force(k, self.lags[lag], column, joint) for lag, column in enumerate(columns)]
            found.append(min(forces, key=lambda each: each.left))
            if self.servos[k]:
                servos = [_as_servo(k, self.lags[lag], column, joint) for lag, column in enumerate(columns)]
                found.append(min(servos, key=lambda each: each.left))
        return tuple(sorted(found, key=lambda each: each.left))


class _Joint(NamedTuple):
    """A joint under a reading, by test function: what it needed, brakes, where it was, and constants; squares to 1."""

    dof: int
    need: Array
    brakes: Array
    place: Array
    constants: Array
    size: float


def _as_force(k: int, lag: float, column: Array, joint: _Joint) -> Given:
    unit = float(np.abs(column).max()) or 1.0
    free = np.column_stack([column / unit, joint.constants])
    c, x, left = _fit(joint.need, free, joint.brakes)
    std = _std(np.column_stack([free, joint.brakes[:, x > 0]]), left) / unit
    return Given(k, lag, float(c[0]) / unit, 0.0, 0.0, float(c[1]), left / joint.size, std, float(x[2]))


def _as_servo(k: int, lag: float, column: Array, joint: _Joint) -> Given:
    """Need = kp (f · series − q) − kv q' beside what brakes; f is a unit, or a sign."""
    unit = float(np.abs(column).max()) or 1.0
    free = np.column_stack([column / unit, joint.constants])
    c, x, left = _fit(joint.need, free, np.column_stack([-joint.place, joint.brakes]))
    return Given(k, lag, float(c[0]) / unit, float(x[0]), float(x[1]), float(c[1]), left / joint.size)


def _std(columns: Array, left: float) -> float:
    """Standard deviation of the first coefficient of a least-squares fit."""
    count, known = columns.shape
    others = np.linalg.qr(columns[:, 1:])[0]
    alone = columns[:, 0] - others @ (others.T @ columns[:, 0])
    squares = float((alone**2).sum())
    return float(np.sqrt(left / (max(count - known, 1) * squares))) if squares > 0 else np.inf


def _brakes(project: object, motion: Motion, dof: int, *, spring: bool) -> Array:
    """What may brake a joint: viscous and dry friction, a rotor, and a spring if there may be one."""
    speed, bend = motion.qvel[:, dof], motion.qacc[:, dof]
    slow = SLOW * float(np.sqrt((speed**2).mean())) or 1.0
    pull = [-motion.qpos[:, dof]] if spring else []
    columns = np.stack([-speed, -np.tanh(speed / slow), -bend, *pull], axis=1)
    return project(columns)  # pyright: ignore[reportCallIssue]


def _fit(need: Array, free: Array, brakes: Array) -> tuple[Array, Array, float]:
    """Least squares with some coefficients of any sign and others that are not negative.

    The free columns are projected out first.

    Returns:
        The free coefficients, the others, and the squares that remain.
    """
    basis, triangle = np.linalg.qr(free)
    rest = brakes - basis @ (basis.T @ brakes)
    whole, size = (np.sqrt((columns**2).sum(0)) for columns in (brakes, rest))
    own = size > _APART * whole
    x = np.zeros(brakes.shape[1])
    x[own] = nnls(rest[:, own] / size[own], need - basis @ (basis.T @ need))[0] / size[own]
    left = need - brakes @ x
    c = np.linalg.lstsq(triangle, basis.T @ left, rcond=None)[0]
    return np.asarray(c, np.float64), x, float(((left - free @ c) ** 2).sum())
