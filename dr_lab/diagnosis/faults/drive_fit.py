"""How strongly logged commands act: the drive of each actuator regressed on what the motion needs, log by log."""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from dr_lab.diagnosis.faults.equation_error import Actuation, Demand, Weak, actuation, demand, weak_form
from dr_lab.diagnosis.faults.fault_settings import FaultSettings
from dr_lab.diagnosis.faults.smoothed_motion import Mask, Motion, controls_at
from dr_lab.diagnosis.windows.commands import actuator_columns
from dr_lab.trajectory import Array, Log

_FRICTION = 1  # column of dry friction among what may explain the rest


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
        straight: what they would give going straight from sample to sample, shape (w,); None where they come often.
        speed: the joint's mean velocity, in units of its root mean square, shape (w,).
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
    straight: Array | None
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
    model: mujoco.MjModel, logs: Sequence[Log], motion: Motion, settings: FaultSettings
) -> tuple[DriveFit, ...]:
    """Regressions of all commanded actuators in all logs; those without a moving joint or test function are left out.

    Args:
        model: compiled model.
        logs: the logs.
        motion: their smoothed motion.
        settings: of the weak form, what may explain the rest, and how rarely commands may come.
    """
    needed = demand(model, motion)
    given = actuation(model, motion, controls_at(model, logs, motion))
    rare = settings.coarse * motion.step
    straight = given
    if any(command.wait > rare for log in logs for command in log.commands.values()):
        straight = actuation(model, motion, controls_at(model, logs, motion, straight=True))
    weak = weak_form(motion, settings.equation, needed.touching)
    every = _Forces(model, motion, needed, given, straight, weak, settings)
    sent = [i for i in range(model.nactuator) if model.actuator(i).name in actuator_columns(model, logs)]
    fits = []
    for k, log in enumerate(logs):
        for i in sent:
            coarse = log.commands.get(model.actuator(i).name)
            fits.append(every.fit(log, k, i, straight=coarse is not None and coarse.wait > rare))
    return tuple(fit for fit in fits if fit is not None)


@dataclass(frozen=True)
class _Forces:
    """All forces over the grid of a motion."""

    model: mujoco.MjModel
    motion: Motion
    needed: Demand
    given: Actuation
    straight: Actuation
    weak: Weak
    settings: FaultSettings

    def fit(self, log: Log, k: int, i: int, *, straight: bool) -> DriveFit | None:
        """The regression of actuator i in the k-th log; None where nothing can be said."""
        rows, grid = self.weak.log == k, self.motion.log == k
        if rows.sum() < self.settings.fewest:
            return None
        dof = int(np.abs(self.given.driven[grid, i]).sum(0).argmax())
        force = self.given.driven[grid, i, dof]
        if not force.any():
            return None
        need = self._mean(self.needed.force[:, dof] - self.given.idle[:, dof], rows)
        others, low, high = self._others(rows, grid, i, dof, float(np.sqrt((need**2).mean())))
        index = self.weak.index[rows] - int(np.argmax(grid))
        return DriveFit(
            log=log,
            actuator=self.model.actuator(i).name,
            joint=self.model.joint(int(self.model.dof_jntid[dof])).name,
            time=self.weak.time[rows],
            need=need,
            drive=force[index] @ self.weak.weight,
            straight=self._mean(self.straight.driven[:, i, dof], rows) if straight else None,
            speed=others[:, 0],
            others=others,
            low=low,
            high=high,
            force=force,
            index=index,
            weight=self.weak.weight,
            step=self.motion.step,
        )

    def _others(self, rows: Mask, grid: Mask, i: int, dof: int, size: float) -> tuple[Array, Array, Array]:
        """What may explain the rest of a need of this size: columns of typical size 1, least and largest coefficient.

        Viscous and dry friction brake, whatever their size, but for the model's own that may be too large.
        """
        speed, rules = self.motion.qvel[:, dof], self.settings
        wrong, overdone = rules.wrong * size, rules.overdone * size
        slow = rules.slow * float(np.sqrt((speed[grid] ** 2).mean())) or 1.0
        place = self.motion.qpos[:, self.model.jnt_qposadr[self.model.dof_jntid[dof]]]
        forces = [
            (speed, -np.inf, overdone),
            (np.tanh(speed / slow), -np.inf, overdone),
            (place - place[grid].mean(), -wrong, wrong),
            (np.ones(len(speed)), -wrong, wrong),
            *((self.given.driven[:, j, dof], -np.inf, np.inf) for j in range(self.given.driven.shape[1]) if j != i),
        ]
        columns = [self._mean(force, rows) for force, _, _ in forces]
        columns = [column / (float(np.sqrt((column**2).mean())) or 1.0) for column in columns]
        columns += [self._mean(part[:, dof], rows) for part in (self.needed.gravity, self.needed.inertia)]
        bounds = [(low, high) for _, low, high in forces] + [(-rules.wrong, rules.wrong)] * 2
        low, high = np.array(bounds).T
        return np.stack(columns, axis=1), low, high

    def _mean(self, values: Array, rows: Mask) -> Array:
        return values[self.weak.index[rows]] @ self.weak.weight
