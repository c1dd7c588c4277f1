"""How strongly logged commands act: the drive of each actuator regressed on what the motion needs, log by log."""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from dr_lab.diagnosis.commands import actuator_columns
from dr_lab.diagnosis.equation_error import Actuation, Demand, Weak, actuation, demand, weak_form
from dr_lab.diagnosis.smoothed_motion import EquationErrorSettings, Motion, controls_at
from dr_lab.trajectory import Array, Log

Mask = NDArray[np.bool_]
_WRONG = 0.3  # largest error of a nominal model, as a share of gravity, inertia and (springs, offsets) of the need
_SLOW = 0.05  # of the root mean square speed: below it, friction's direction is undecided
_FRICTION = 1  # column of dry friction among what may explain the rest
_FEWEST = 16  # test functions that a regression is worth


@dataclass(frozen=True)
class Gain:
    """Best regression of what a motion needs on a drive.

    Attributes:
        gain: factor of the drive, 1 where the model and the logs are right.
        left: sum of squares that it leaves, (N·m)² or N².
        rest: what the other columns leave of the need to the drive, shape (w,).
        friction: dry friction that was found beside it, N·m or N.
    """

    gain: float
    left: float
    rest: Array
    friction: float


@dataclass(frozen=True)
class DriveFit:
    """One actuator in one log, at the joint that it moves most; w test functions.

    Attributes:
        log: the log.
        actuator: name.
        joint: name.
        time: middles of the test functions, s, shape (w,).
        need: what the motion needs beyond idle actuators, N·m or N, shape (w,).
        drive: what the commands give as logged, shape (w,).
        speed: mean velocity, shape (w,).
        others: columns that may explain the rest, shape (w, p).
        low: least coefficient of each, shape (p,).
        high: largest coefficient of each, shape (p,).
        force: the drive on the log's even grid, shape (n,).
        index: where each test function lives on it, shape (w, m).
        weight: of the test functions on the grid, shape (m,).
        step: s, of the grid.
    """

    log: Log
    actuator: str
    joint: str
    time: Array
    need: Array
    drive: Array
    speed: Array
    others: Array
    low: Array
    high: Array
    force: Array
    index: NDArray[np.intp]
    weight: Array
    step: float

    def gain(self, low: float, high: float, rows: Mask | None = None, drive: Array | None = None) -> Gain:
        """Bounded least squares need = gain · drive + others · b on some test functions.

        Args:
            low: least gain.
            high: largest gain; equal to `low` it is given.
            rows: test functions that count, shape (w,); None takes all.
            drive: another drive, shape (w,).
        """
        rows = np.ones(len(self.time), bool) if rows is None else rows
        x = self.drive if drive is None else drive
        free = high > low
        columns = np.column_stack([x, self.others]) if free else self.others
        goal = self.need if free else self.need - low * x
        size = np.sqrt((columns[rows] ** 2).sum(0))
        size[size == 0.0] = 1.0
        basis, triangle = np.linalg.qr(columns[rows] / size)
        least, most = (np.append(g, b) if free else b for g, b in ((low, self.low), (high, self.high)))
        found = lsq_linear(triangle, basis.T @ goal[rows], (least * size, most * size), method="bvls")
        b = found.x / size
        gain, b = (float(b[0]), b[1:]) if free else (low, b)
        rest = self.need - self.others @ b
        return Gain(gain, float(((rest - gain * x)[rows] ** 2).sum()), rest, abs(float(b[_FRICTION])))

    def late(self, lag: float) -> tuple[Array, Mask]:
        """The drive as if it came later by a lag in s, and the test functions for which the log knows it."""
        index = self.index - round(lag / self.step)
        inside = np.all((index >= 0) & (index < len(self.force)), axis=1)
        return self.force[np.clip(index, 0, len(self.force) - 1)] @ self.weight, inside


def drive_fits(
    model: mujoco.MjModel, logs: Sequence[Log], motion: Motion, settings: EquationErrorSettings
) -> tuple[DriveFit, ...]:
    """Regressions of all commanded actuators in all logs; those without a moving joint or test function are left out.

    Args:
        model: compiled model.
        logs: the logs.
        motion: their smoothed motion.
        settings: of the weak form.
    """
    needed = demand(model, motion)
    given = actuation(model, motion, controls_at(model, logs, motion))
    weak = weak_form(motion, settings, needed.touching)
    sent = [i for i in range(model.nactuator) if model.actuator(i).name in actuator_columns(model, logs)]
    found = []
    for k, log in enumerate(logs):
        for i in sent:
            fit = _fit(model, log, k, i, motion, needed, given, weak)
            if fit is not None:
                found.append(fit)
    return tuple(found)


def _fit(
    model: mujoco.MjModel, log: Log, k: int, i: int, motion: Motion, needed: Demand, given: Actuation, weak: Weak
) -> DriveFit | None:
    rows, grid = weak.log == k, motion.log == k
    first = int(np.argmax(grid))
    dof = int(np.abs(given.driven[grid, i]).sum(0).argmax()) if grid.any() else 0
    force = given.driven[grid, i, dof]
    index = weak.index[rows] - first
    if rows.sum() < _FEWEST or not force.any():
        return None
    project = lambda values: values[grid][index] @ weak.weight  # noqa: E731
    speed = motion.qvel[:, dof]
    slow = _SLOW * np.sqrt((speed[grid] ** 2).mean()) or 1.0
    place = motion.qpos[:, model.jnt_qposadr[model.dof_jntid[dof]]]
    need = project(needed.force[:, dof] - given.idle[:, dof])
    size = np.sqrt((need**2).mean())
    # What may explain the rest, its least and its largest coefficient, as shares of the need where they are forces.
    others = [
        (project(speed), -np.inf, 0.3 * _WRONG * size),
        (project(np.tanh(speed / slow)), -np.inf, 0.3 * _WRONG * size),
        (project(place - place[grid].mean()), -_WRONG * size, _WRONG * size),
        (np.ones(len(index)), -_WRONG * size, _WRONG * size),
        *((project(given.driven[:, j, dof]), -np.inf, np.inf) for j in range(given.driven.shape[1]) if j != i),
        (project(needed.gravity[:, dof]), -_WRONG, _WRONG),
        (project(needed.inertia[:, dof]), -_WRONG, _WRONG),
    ]
    shapes, low, high = zip(*others, strict=True)
    own = np.array([float(np.sqrt((shape**2).mean())) or 1.0 for shape in shapes])
    own[-2:] = 1.0
    return DriveFit(
        log=log,
        actuator=model.actuator(i).name,
        joint=model.joint(int(model.dof_jntid[dof])).name,
        time=weak.time[rows],
        need=need,
        drive=force[index] @ weak.weight,
        speed=shapes[0],
        others=np.stack(shapes, axis=1),
        low=np.array(low) / own,
        high=np.array(high) / own,
        force=force,
        index=index,
        weight=weak.weight,
        step=motion.step,
    )
