"""What gyroscopes say of the joints: by the model's kinematics they turn as the joints' measured angles do.

The rate ω = J(q) q' that a gyroscope reads follows from the joints' angles alone, whatever masses or forces the model
lacks. So it tells signs, units and zeros of the joints that carry it before any force is looked at.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import permutations, product
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.proposal.grid import Grid, known_in, path_of
from dr_lab.proposal.search import Options, Readings
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.survey import Series
from dr_lab.proposal.trial import Reading, Trial
from dr_lab.proposal.zeros import OFFSETS
from dr_lab.trajectory import Array

TURNS: Mapping[str, float] = {"rad/s": 1.0, "deg/s": np.pi / 180}  # units that gyroscopes have
_TIMES = 300  # at which rates are compared; a handful of unknowns is fixed by far fewer


class Compared(NamedTuple):
    """Rates that a gyroscope logged, raw, beside those of the model's, each about its mean, as a gyroscope has a bias.

    Attributes:
        cross: Σ logged · expected, shape (axes, 3).
        logged: Σ logged², over all axes.
        expected: Σ expected², by axis, shape (3,).
    """

    cross: Array
    logged: float
    expected: Array

    def left(self, factor: float, axes: Sequence[int], signs: Sequence[int]) -> float:
        """Share of the squares that is left between sign · factor · logged and the axes expected, column by column."""
        logged, expected = factor**2 * self.logged, float(self.expected[[*axes]].sum())
        shared = factor * sum(
            sign * self.cross[k, axis] for k, (axis, sign) in enumerate(zip(axes, signs, strict=True))
        )
        return float(logged + expected - 2 * shared) / max(logged, expected, np.finfo(float).tiny)


@dataclass(frozen=True)
class Gyro:
    """A gyroscope of the model and what the logs hold of it.

    Attributes:
        sensor: its name.
        site: where it sits.
        axes: that its columns say: 0, 1, 2 for x, y, z.
        joints: that carry it, as places among the model's.
        values: raw numbers, smoothed, shape (n, axes).
        rows: places of these times in the grid, shape (n,).
        units: factors to rad/s that they may have.
    """

    sensor: str
    site: int
    axes: tuple[int, ...]
    joints: tuple[int, ...]
    values: Array
    rows: NDArray[np.intp]
    units: tuple[float, ...] = tuple(TURNS.values())


@dataclass(frozen=True)
class Gyros:
    """All gyroscopes of a robot, compared with readings of its joints.

    Attributes:
        trial: gives the motion of a reading.
        gyros: at least one.
        settings: thresholds.
        known: shares left by what carries the gyroscopes.
    """

    trial: Trial
    gyros: tuple[Gyro, ...]
    settings: ProposalSettings
    known: dict[tuple[Reading, ...], float] = field(default_factory=dict)

    @property
    def joints(self) -> list[int]:
        """The joints that carry any of them."""
        return sorted({joint for gyro in self.gyros for joint in gyro.joints})

    def left(self, readings: Readings) -> float:
        """Share of the rates' squares that is left, the gyroscopes being mounted as the model says; their mean."""
        key = tuple(readings[j] for j in self.joints)
        if key not in self.known:
            every = [
                min(compared.left(unit, gyro.axes, [1] * len(gyro.axes)) for unit in gyro.units)
                for gyro, compared in self.compared(readings)
            ]
            self.known[key] = float(np.mean(every))
        return self.known[key]

    def compared(self, readings: Readings) -> Iterator[tuple[Gyro, Compared]]:
        """Each gyroscope with its rates beside those that a reading of the joints asks for."""
        motion = self.trial.motion(readings)
        for gyro in self.gyros:
            expected = rates(self.trial.model, gyro.site, motion.qpos[gyro.rows], motion.qvel[gyro.rows])
            expected, logged = expected - expected.mean(0), gyro.values - gyro.values.mean(0)
            yield gyro, Compared(logged.T @ expected, float((logged**2).sum()), (expected**2).sum(0))

    def asked_for(self, options: Sequence[Options], readings: Readings) -> Readings | None:
        """The reading that the gyroscopes ask for: another sign, unit or zero of a joint as long as that leaves less.

        None where they do not turn so either, or far better if they were mounted otherwise than the model says.
        """
        found, near, close = readings, self.settings.near, self.settings.close
        while True:
            others = [other for j in self.joints for other in _others(options[j], j, found)]
            best = min(others, key=self.left, default=found)
            if near * self.left(best) + close >= self.left(found):
                break
            found = best
        otherwise = np.mean([least(gyro, compared) for gyro, compared in self.compared(readings)])
        return found if self.left(found) <= min(self.settings.fits, near * float(otherwise) + close) else None


def gyros_of(trial: Trial, worn: Mapping[str, Mapping[int, Series]], settings: ProposalSettings) -> Gyros | None:
    """The gyroscopes that joints carry and whose rates are known while the joints' angles are; None without any.

    Args:
        trial: gives robot and times.
        worn: by the name of a sensor, which series is which of its axes.
        settings: how series are smoothed.
    """
    found = []
    for sensor, series in worn.items():
        site = int(trial.model.sensor(sensor).objid[0])
        known = np.flatnonzero(known_in([*series.values()], trial.grid))
        joints = _carrying(trial.model, int(trial.model.site_bodyid[site]))
        if len(known) and joints:
            part = Grid(trial.grid.log[known], trial.grid.time[known], trial.grid.weight, trial.grid.step)
            values = np.stack([path_of(each, part, settings.cutoff).value for each in series.values()], axis=1)
            rows = np.arange(trial.grid.time.size).reshape(trial.grid.time.shape)[known].ravel()
            some = slice(None, None, -(-len(rows) // _TIMES))
            found.append(Gyro(sensor, site, tuple(series), joints, values[some], rows[some]))
    return Gyros(trial, tuple(found), settings) if found else None


def rates(model: mujoco.MjModel, site: int, qpos: Array, qvel: Array) -> Array:
    """Angular rate of a site in its own axes at every time of a motion, shape (n, 3), rad/s."""
    data, found, turning = mujoco.MjData(model), np.zeros((len(qpos), 3)), np.zeros(6)
    for k, (place, speed) in enumerate(zip(qpos, qvel, strict=True)):
        data.qpos[:], data.qvel[:] = place, speed
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_comVel(model, data)
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_SITE, site, turning, 1)
        found[k] = turning[:3]
    return found


def orders(gyro: Gyro) -> Iterator[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Every axis of the model that each column may read, and every sign."""
    count = len(gyro.axes)
    yield from product(permutations(range(3), count), product((1, -1), repeat=count))


def least(gyro: Gyro, compared: Compared) -> float:
    """Share of the squares that is left with the order, signs and unit of the columns that leave least."""
    return min(compared.left(unit, *order) for order in orders(gyro) for unit in gyro.units)


def _carrying(model: mujoco.MjModel, body: int) -> tuple[int, ...]:
    """The joints between the world and a body."""
    found = list[int]()
    while body:
        first = int(model.body_jntadr[body])
        found += range(first, first + int(model.body_jntnum[body]))
        body = int(model.body_parentid[body])
    return tuple(sorted(found))


def _others(options: Options, joint: int, readings: Readings) -> Iterator[Readings]:
    """The readings with another sign, unit and zero of a joint."""
    for unit, sign, offset in product(options.units, (1, -1), (0.0, *OFFSETS) if options.angle else (0.0,)):
        each = replace(readings[joint], factor=sign * unit, offset=offset)
        if each != readings[joint]:
            yield (*readings[:joint], each, *readings[joint + 1 :])
