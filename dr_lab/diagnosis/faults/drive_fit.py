"""How strongly logged commands act: what each joint's motion needs, regressed on an actuator's drive, log by log."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from dr_lab.diagnosis.faults.equation_error import Actuation, Demand, Weak, actuation, demand, weak_form
from dr_lab.diagnosis.faults.fault_settings import FaultSettings
from dr_lab.diagnosis.faults.smoothed_motion import Mask, Motion, controls_at, smoothed_motion, untestable
from dr_lab.diagnosis.windows.commands import actuator_columns
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array, Log, MeasurementSet

FRICTION = 1  # column of dry friction among what may explain the rest
_AT_JOINT = int(mujoco.mjtTrn.mjTRN_JOINT)


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
    """One joint in one log, and an actuator that moves it most of all; w test functions.

    Attributes:
        log: the log.
        actuator: name, empty where no drive is looked at.
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
        return Gain(gain, float(((rest - gain * x)[rows] ** 2).sum()), rest, abs(float(b[FRICTION])))

    def late(self, lag: float) -> tuple[Array, Mask]:
        """The drive as if it came later by a lag in s, and the test functions for which the log knows it."""
        index = self.index - round(lag / self.step)
        inside = np.all((index >= 0) & (index < len(self.force)), axis=1)
        return self.force[np.clip(index, 0, len(self.force) - 1)] @ self.weight, inside


@dataclass(frozen=True)
class Forces:
    """All forces over the grid of a motion.

    Attributes:
        model: compiled model.
        logs: the logs.
        motion: their smoothed motion.
        needed: what it needs.
        given: what the actuators give.
        straight: what they would give with commands going straight from sample to sample.
        weak: test functions.
        settings: what may explain the rest of a need, and how rarely commands may come.
    """

    model: mujoco.MjModel
    logs: Sequence[Log]
    motion: Motion
    needed: Demand
    given: Actuation
    straight: Actuation
    weak: Weak
    settings: FaultSettings

    @classmethod
    def of(cls, model: mujoco.MjModel, logs: Sequence[Log], motion: Motion, settings: FaultSettings) -> "Forces":
        """The forces of logs; attributes as of the class."""
        needed = demand(model, motion)
        given = straight = actuation(model, motion, controls_at(model, logs, motion))
        if any(_rare(log, name, model, settings) for log in logs for name in log.commands):
            straight = actuation(model, motion, controls_at(model, logs, motion, straight=True))
        weak = weak_form(motion, settings.equation, needed.touching)
        return cls(model, logs, motion, needed, given, straight, weak, settings)

    def drives(self) -> list[DriveFit]:
        """Regressions of all commanded actuators in all logs, but those without a moving joint or test function."""
        sent = [i for i in range(self.model.nactuator) if self.model.actuator(i).name in self._commanded]
        found = (self._drive(k, i) for k in range(len(self.logs)) for i in sent)
        return [each for each in found if each is not None]

    def undriven(self) -> list[DriveFit]:
        """The same of joints without a drive, whose actuators are all among what may explain the rest.

        A joint is left out where an actuator may hold it whose commands are not logged.
        """
        pairs = [(k, dof) for k in range(len(self.logs)) for dof in range(self.model.nv) if not self._unlogged(k, dof)]
        return [self._fit(k, dof, None) for k, dof in pairs if self._rows(k).sum() >= self.settings.fewest]

    def unexplained(self, low: float, high: float) -> Array:
        """Share of each joint's forces that its commands do not explain, over all logs, shape (nv,).

        A share of the squares of the inertial and gravitational forces about their means, or of what is needed, where
        that is more. Of several actuators at a joint the one counts that leaves most, the others being free.

        Args:
            low: least gain of the commands.
            high: largest gain.
        """
        found = [*self.undriven(), *self.drives()]
        driven = {(fit.log.name, fit.joint) for fit in found if fit.actuator}
        left, size = np.zeros((2, self.model.nv))
        for k, log in enumerate(self.logs):
            for dof in range(self.model.nv):
                joint = self.model.joint(int(self.model.dof_jntid[dof])).name
                fits = [fit for fit in found if (fit.log.name, fit.joint) == (log.name, joint)]
                fits = [fit for fit in fits if bool(fit.actuator) == ((log.name, joint) in driven)]
                if fits:
                    bounds = (low, high) if fits[0].actuator else (0.0, 0.0)
                    left[dof] += max(fit.gain(*bounds).left for fit in fits)
                    size[dof] += self._size(k, dof, fits[0].need)
        return np.divide(left, size, out=np.zeros_like(left), where=size > 0)

    def _size(self, k: int, dof: int, need: Array) -> float:
        """Squares of a joint's forces about their means in the k-th log."""
        rows = self._rows(k)
        parts = (self._mean(part[:, dof], rows) for part in (self.needed.inertia, self.needed.gravity))
        return max(sum(float(((part - part.mean()) ** 2).sum()) for part in parts), float(need.var() * len(need)))

    def friction(self, joint: str) -> float:
        """Dry friction that the model has at a joint, N·m or N; that of all tendons counts."""
        own = self.model.dof_frictionloss[self.model.joint(joint).dofadr[0]]
        return float(own + self.model.tendon_frictionloss.sum())

    def _unlogged(self, k: int, dof: int) -> bool:
        """Whether an actuator of a degree of freedom, or of a tendon or a body, has no commands in the k-th log."""
        silent = [i for i in range(self.model.nactuator) if self.model.actuator(i).name not in self.logs[k].commands]
        return any(
            int(self.model.actuator_trntype[i]) != _AT_JOINT
            or int(self.model.jnt_dofadr[self.model.actuator_trnid[i, 0]]) == dof
            for i in silent
        )

    @property
    def _commanded(self) -> Mapping[str, int]:
        return actuator_columns(self.model, self.logs)

    def _rows(self, k: int) -> Mask:
        return self.weak.log == k

    def _drive(self, k: int, i: int) -> DriveFit | None:
        grid = self.motion.log == k
        dof = int(np.abs(self.given.driven[grid, i]).sum(0).argmax())
        enough = self._rows(k).sum() >= self.settings.fewest
        return self._fit(k, dof, i) if enough and self.given.driven[grid, i, dof].any() else None

    def _fit(self, k: int, dof: int, i: int | None) -> DriveFit:
        """The regression of a joint's need in the k-th log on the drive of actuator i, or on none."""
        rows, grid, log = self._rows(k), self.motion.log == k, self.logs[k]
        force = np.zeros(int(grid.sum())) if i is None else self.given.driven[grid, i, dof]
        need = self._mean(self.needed.force[:, dof] - self.given.idle[:, dof], rows)
        size = float(np.sqrt((need**2).mean())) or 1.0  # bounds of no width cannot be kept to
        others, low, high = self._others(rows, grid, i, dof, size)
        index = self.weak.index[rows] - int(np.argmax(grid))
        name = "" if i is None else self.model.actuator(i).name
        straight = None
        if i is not None and name in log.commands and _rare(log, name, self.model, self.settings):
            straight = self._mean(self.straight.driven[:, i, dof], rows)
        return DriveFit(
            log=log,
            actuator=name,
            joint=self.model.joint(int(self.model.dof_jntid[dof])).name,
            time=self.weak.time[rows],
            need=need,
            drive=force[index] @ self.weak.weight,
            straight=straight,
            speed=others[:, 0],
            others=others,
            low=low,
            high=high,
            force=force,
            index=index,
            weight=self.weak.weight,
            step=self.motion.step,
        )

    def _others(self, rows: Mask, grid: Mask, i: int | None, dof: int, size: float) -> tuple[Array, Array, Array]:
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


def forces_of(model: Model, measured: MeasurementSet, settings: FaultSettings) -> Forces | None:
    """The forces of all logs by the model as given; None of machines whose equation of motion cannot be tested.

    These are in contact throughout, or have joints that are not measured or actuators of which no log has a command.
    """
    compiled, logs = model.nominal(), (*measured.fit, *measured.held_out)
    silent = compiled.nactuator and not any(log.commands for log in logs)  # what moves the machine is not known
    if silent or untestable(compiled, measured):
        return None
    return Forces.of(compiled, logs, smoothed_motion(compiled, measured, logs, settings.equation), settings)


def _rare(log: Log, name: str, model: mujoco.MjModel, settings: FaultSettings) -> bool:
    """Whether a command's samples come so rarely that it matters what it did between them."""
    wait = log.commands[name].wait
    return settings.is_coarse(wait) or wait > settings.rare * model.opt.timestep
