"""What effects at actuators could give along a course."""

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from dr_lab.plants.alike.at_drives import AtDrives, groups
from dr_lab.plants.alike.course import Course, mean_held
from dr_lab.plants.alike.extent import Extent
from dr_lab.plants.alike.forces import Forces
from dr_lab.plants.alike.grids import Grids
from dr_lab.plants.alike.response import Signature
from dr_lab.plants.alike.rival import Choice, Rival, along, linear
from dr_lab.trajectory import Array


def actuator_rivals(course: Course, grids: Grids, extent: Extent, forces: Forces) -> Iterator[Rival]:
    """Effects of every actuator, then of all together.

    Args:
        course: where the machine moves.
        grids: shapes that are tried.
        extent: how far all logs reach, this one among them.
        forces: along the course.
    """
    names = course.machine.actuators
    every = range(len(names))
    servos = [row for row in every if names[row] in forces.pulled]
    motors = [row for row in every if row not in servos]
    for rival, rows, sizeless in (
        (_gain_error, servos, True),
        (_force_limit, servos, False),
        (_actuator_delay, every, True),
        (_actuator_lag, every, True),
        (_rate_limit, every, False),
        (_saturation, every, False),
        (_dead_zone, motors, False),
        (_voltage_sag, motors, False),
        (_command_power, motors, False),
        (_torque_scale, every, True),
        (_torque_speed_limit, motors, False),
        (_coasting_bridge, motors, False),
    ):
        for group in groups(course, rows, sizeless=sizeless):
            yield rival(AtDrives(course, grids, extent, forces, group))


def _gain_error(at: AtDrives) -> Rival:
    low, high = at.grids.gains
    stiffer = at.added(lambda row: at.forces.pulled[at.course.machine.actuators[row]])
    return Rival(f"gain_error@{at.site}", 1, (Choice([stiffer], [low - 1], [high - 1]),))


def _force_limit(at: AtDrives) -> Rival:
    def cut(end: float) -> Signature:
        return at.added(lambda row: np.clip(at.whole(row), -end, end) - at.whole(row))

    return Rival(f"force_limit@{at.site}", 1, along([cut(share * at.strongest) for share in (1.0, *at.grids.limits)]))


def _actuator_delay(at: AtDrives) -> Rival:
    def late(delay: float) -> Signature:
        sent = at.course.sent
        return at.changed(lambda row: mean_held(replace(sent[row], edge=sent[row].edge + delay), at.course.edge))

    return Rival(f"actuator_delay@{at.site}", 1, along([late(delay) for delay in (0.0, *at.grids.delays)]))


def _actuator_lag(at: AtDrives) -> Rival:
    slow = [_followed(at, lagged, constant) for constant in at.grids.lags]
    return Rival(f"actuator_lag@{at.site}", 1, along([at.changed(at.means.__getitem__), *slow]))


def _rate_limit(at: AtDrives) -> Rival:
    ramps = [_followed(at, ramped, at.largest / time) for time in at.grids.ramps]
    return Rival(f"rate_limit@{at.site}", 1, along([at.changed(at.means.__getitem__), *ramps]))


def _followed(at: AtDrives, by: Callable[[Array, Array, float], Array], number: float) -> Signature:
    """Commands as a driver follows them; it still shows what was sent before the first interval."""
    time = at.course.path[0].time
    earlier = time[time < at.course.edge[0]]
    edge = np.concatenate([earlier, at.course.edge])
    step, sent = np.diff(edge), at.course.sent
    return at.changed(lambda row: by(mean_held(sent[row], edge), step, number)[len(earlier) :])


def _saturation(at: AtDrives) -> Rival:
    def cut(limit: float) -> Signature:
        return at.changed(lambda row: np.clip(at.means[row], -limit, limit))

    return Rival(f"saturation@{at.site}", 1, along([cut(share * at.largest) for share in (1.0, *at.grids.limits)]))


def _dead_zone(at: AtDrives) -> Rival:
    def dead(width: float) -> Signature:
        return at.changed(lambda row: np.sign(at.means[row]) * np.maximum(np.abs(at.means[row]) - width, 0.0))

    return Rival(f"dead_zone@{at.site}", 1, along([dead(share * at.largest) for share in (0.0, *at.grids.dead)]))


def _voltage_sag(at: AtDrives) -> Rival:
    sagging = at.acting(lambda row: -at.means[row] * np.abs(at.means[row]))
    return Rival(f"voltage_sag@{at.site}", 1, linear(sagging, positive=True))


def _command_power(at: AtDrives) -> Rival:
    """Powers of a command in its place, full (|u| / full)^p = (full / largest)^(1 − p) · largest (|u| / largest)^p.

    The factor stays within what each two neighbours of the grid of `full` give. At 0 there would be no drive, and with
    the masses and dampings free no machine either, which leaves nothing of anything.
    """

    def power(exponent: float) -> Signature:
        return at.acting(lambda row: powered(at.means[row], at.largest, exponent))

    choices, taken = [], at.acting(lambda row: -at.means[row])
    for before, after in itertools.pairwise(at.grids.exponents):
        one, two = power(before), power(after)
        onwards = Signature(two.force - one.force, two.reading - one.reading)
        factors = np.sort(np.asarray(at.grids.fulls) ** (1 - 0.5 * (before + after)))
        for low, high in itertools.pairwise(factors.tolist()):
            choices.append(Choice([one, onwards], [low, 0.0], [high, high], taken))
    return Rival(f"command_power@{at.site}", 2, tuple(choices))


def _torque_scale(at: AtDrives) -> Rival:
    low, high = at.grids.scales
    return Rival(f"torque_scale@{at.site}", 1, (Choice([at.added(at.whole)], [low - 1], [high - 1]),))


def _torque_speed_limit(at: AtDrives) -> Rival:
    """The limit that falls with speed, at the joint that each actuator drives alone."""
    fastest = max(float(at.extent.speed[at.joint(row)]) for row in at.rows)

    def limited(stall: float, free: float) -> Signature:
        def lost(row: int) -> Array:
            whole, joint = at.whole(row), at.joint(row)
            share, given = at.course.velocity[:, joint] / free, np.zeros_like(whole)
            given[:, joint] = np.clip(whole[:, joint], -stall * (1 + share), stall * (1 - share)) - whole[:, joint]
            return given

        return at.added(lost)

    choices = []
    for stall in at.strongest * np.asarray(at.grids.stalls):
        choices += along([limited(float(stall), share * fastest) for share in at.grids.speeds])
    return Rival(f"torque_speed_limit@{at.site}", 2, tuple(choices))


def _coasting_bridge(at: AtDrives) -> Rival:
    coasting = at.added(lambda row: -np.abs(at.whole(row)) * at.course.velocity)
    return Rival(f"coasting_bridge@{at.site}", 1, linear(coasting, positive=True))


def lagged(mean: Array, step: Array, constant: float) -> Array:
    """Mean over each interval of a command that acts through a first-order lag, shape (K,)."""
    left = np.exp(-step / constant)
    share = constant / step * (1 - left)
    now, shown = float(mean[0]), np.zeros(len(mean))
    for k, (u, kept, part) in enumerate(zip(mean.tolist(), left.tolist(), share.tolist(), strict=True)):
        shown[k], now = u + (now - u) * part, u + (now - u) * kept
    return shown


def ramped(mean: Array, step: Array, rate: float) -> Array:
    """Mean over each interval of a command that is followed at a limited rate (units per s), shape (K,)."""
    now, shown = float(mean[0]), []
    for u, h in zip(mean.tolist(), step.tolist(), strict=True):
        away = u - now
        time = min(abs(away) / rate, h)
        moved = math.copysign(rate * time, away)
        shown.append(now + moved * (1 - 0.5 * time / h))
        now += moved
    return np.array(shown)


def powered(mean: Array, full: float, exponent: float) -> Array:
    """A command of which a power acts, right at the full one."""
    return np.sign(mean) * full * (np.abs(mean) / full) ** exponent
