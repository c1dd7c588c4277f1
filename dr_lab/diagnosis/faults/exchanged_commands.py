"""Commands of two actuators that are exchanged: plugs, columns or addresses that were mixed up."""

import itertools
from collections.abc import Sequence

import numpy as np

from dr_lab.diagnosis.faults.drive_fit import Forces
from dr_lab.diagnosis.faults.misread import Misreading, crossed_words, exchanged, first_logs
from dr_lab.diagnosis.faults.smoothed_motion import smoothed_motion
from dr_lab.trajectory import Array, Log, MeasurementSet


def exchanged_commands(forces: Forces, measured: MeasurementSet) -> Misreading | None:
    """The two actuators whose commands explain the motion of both joints far better the other way round.

    Of either joint the commands as declared must leave a share of what its motion needs, with any plausible gain, and
    the other's commands far less. Where joints swing freely a motor's command is a small part of all forces, which
    `misread` weighs against one another; so it is weighed against the need for it here.

    Args:
        forces: those of all logs as declared.
        measured: all logs.

    Returns:
        The misreading of the pair that leaves least; None where there is none.
    """
    settings, logs = forces.settings, first_logs(forces.logs, forces.settings)
    motion = smoothed_motion(forces.model, measured, logs, settings.equation)
    given = _left(Forces.of(forces.model, logs, motion, settings))
    bad = [name for name, (left, need) in given.items() if left >= settings.share * need]
    found = []
    for pair in itertools.combinations(bad, 2):
        if _unit(logs, pair[0]) != _unit(logs, pair[1]):
            continue
        other = _left(Forces.of(forces.model, [exchanged(log, *pair) for log in logs], motion, settings))
        worst = max(other[name][0] / given[name][0] for name in pair) if {*pair} <= other.keys() else np.inf
        if worst <= settings.contrast:
            found.append((worst, pair))
    if not found:
        return None
    worst, pair = min(found)
    told, remedy = crossed_words(*pair)
    message = f"{told}: the other way round they leave at most {100 * worst:.2g} % of the squares that they leave so."
    return Misreading("swapped", pair[0], message, remedy)


def _left(forces: Forces) -> dict[str, tuple[float, float]]:
    """Squares that each actuator's commands leave of what its joint needs, and of that need, over all logs."""
    band, sums = (forces.settings.gain, 1 / forces.settings.gain), dict[str, Array]()
    for fit in forces.drives():
        both = np.array([fit.gain(*band).left, float(fit.need @ fit.need)])
        sums[fit.actuator] = sums.get(fit.actuator, np.zeros(2)) + both
    return {name: (float(left), float(need)) for name, (left, need) in sums.items()}


def _unit(logs: Sequence[Log], name: str) -> str:
    return next(log.commands[name].unit for log in logs if name in log.commands)
