"""What effects at an actuator could give along a course."""

import itertools
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from dr_lab.plants.alike.course import Course, mean_held
from dr_lab.plants.alike.extent import Extent
from dr_lab.plants.alike.forces import Forces
from dr_lab.plants.alike.grids import Grids
from dr_lab.plants.alike.response import Signature
from dr_lab.plants.alike.rival import Choice, Rival, along, lacked, linear
from dr_lab.trajectory import Array


def actuator_rivals(course: Course, grids: Grids, extent: Extent, forces: Forces) -> Iterator[Rival]:
    """Effects of every actuator.

    Args:
        course: where the machine moves.
        grids: shapes that are tried.
        extent: how far all logs reach, this one among them.
        forces: along the course.
    """
    low, high = grids.gains
    for name, force in forces.pulled.items():
        yield Rival(f"gain_error@{name}", 1, (Choice([lacked(-force)], [low - 1], [high - 1]),))
    for row, name in enumerate(course.machine.actuators):
        whole = forces.driven[:, :, row]
        if name in forces.pulled:
            ends = extent.force[row] * np.array([1.0, *grids.limits])
            yield Rival(f"force_limit@{name}", 1, along([lacked(whole - np.clip(whole, -end, end)) for end in ends]))
        sent, gain = course.sent[row], forces.per_command[:, row]
        mean = mean_held(sent, course.edge)
        largest = float(extent.command[row])

        def changed(values: Array, mean: Array = mean, gain: Array = gain) -> Signature:
            return lacked(-np.outer(values - mean, gain))

        late = [mean_held(replace(sent, edge=sent.edge + d), course.edge) for d in (0.0, *grids.delays)]
        yield Rival(f"actuator_delay@{name}", 1, along([changed(values) for values in late]))
        asked, steps, before = _with_history(course, row)
        slow = [mean, *(lagged(asked, steps, constant)[before:] for constant in grids.lags)]
        yield Rival(f"actuator_lag@{name}", 1, along([changed(values) for values in slow]))
        ramps = [mean, *(ramped(asked, steps, largest / time)[before:] for time in grids.ramps)]
        yield Rival(f"rate_limit@{name}", 1, along([changed(values) for values in ramps]))
        cut = [mean_clipped(mean, share * largest) for share in (1.0, *grids.limits)]
        yield Rival(f"saturation@{name}", 1, along([changed(values) for values in cut]))
        dead = [np.sign(mean) * np.maximum(np.abs(mean) - share * largest, 0.0) for share in (0.0, *grids.dead)]
        yield Rival(f"dead_zone@{name}", 1, along([changed(values) for values in dead]))
        yield Rival(f"voltage_sag@{name}", 1, linear(lacked(np.outer(mean * np.abs(mean), gain)), positive=True))
        yield Rival(f"command_power@{name}", 2, _powers(mean, gain, largest, grids))
        low, high = grids.scales
        yield Rival(f"torque_scale@{name}", 1, (Choice([lacked(-whole)], [low - 1], [high - 1]),))
        yield _limited(course, grids, extent, whole, row)
        coasting = np.abs(whole) * course.velocity
        yield Rival(f"coasting_bridge@{name}", 1, linear(lacked(coasting), positive=True))


def _powers(mean: Array, gain: Array, largest: float, grids: Grids) -> tuple[Choice, ...]:
    """Powers of a command in its place, full (|u| / full)^p = (full / largest)^(1 − p) · largest (|u| / largest)^p.

    The factor stays within what each two neighbours of the grid of `full` give. At 0 there would be no drive, and with
    the masses and dampings free no machine either, which leaves nothing of anything.
    """
    choices = []
    for before, after in itertools.pairwise(grids.exponents):
        one, two = (lacked(-np.outer(powered(mean, largest, exponent), gain)) for exponent in (before, after))
        onwards = Signature(two.force - one.force, two.reading - one.reading)
        factors = np.sort(np.asarray(grids.fulls) ** (1 - 0.5 * (before + after)))
        for low, high in itertools.pairwise(factors.tolist()):
            choices.append(Choice([one, onwards], [low, 0.0], [high, high], lacked(np.outer(mean, gain))))
    return tuple(choices)


def _with_history(course: Course, row: int) -> tuple[Array, Array, int]:
    """Means and lengths of the intervals, with some before the first; what is slow still shows what was sent there.

    Returns:
        Mean commands, lengths in s, and how many intervals are before the first.
    """
    time = course.path[0].time
    earlier = time[time < course.edge[0]]
    edge = np.concatenate([earlier, course.edge])
    return mean_held(course.sent[row], edge), np.diff(edge), len(earlier)


def _limited(course: Course, grids: Grids, extent: Extent, driven: Array, row: int) -> Rival:
    """The limit that falls with speed, at the joint that the actuator drives alone."""
    joint = int(np.abs(driven).sum(axis=0).argmax())
    force, speed, choices = driven[:, joint], course.velocity[:, joint], []
    for stall in extent.force[row] * np.asarray(grids.stalls):
        points = []
        for free in extent.speed[joint] * np.asarray(grids.speeds):
            added = np.zeros_like(driven)
            added[:, joint] = np.clip(force, -stall * (1 + speed / free), stall * (1 - speed / free)) - force
            points.append(lacked(-added))
        choices += along(points)
    return Rival(f"torque_speed_limit@{course.machine.actuators[row]}", 2, tuple(choices))


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
    now, shown = float(mean[0]), np.zeros(len(mean))
    for k, (u, h) in enumerate(zip(mean.tolist(), step.tolist(), strict=True)):
        away = u - now
        time = min(abs(away) / rate, h)
        shown[k] = u - away + np.sign(away) * rate * time * (1 - 0.5 * time / h)
        now += float(np.sign(away)) * rate * time
    return shown


def mean_clipped(mean: Array, limit: float) -> Array:
    """A command that is cut off."""
    return np.clip(mean, -limit, limit)


def powered(mean: Array, full: float, exponent: float) -> Array:
    """A command of which a power acts, right at the full one."""
    return np.sign(mean) * full * (np.abs(mean) / full) ** exponent
