"""Commands of two actuators that are exchanged: plugs, columns or addresses that were mixed up."""

import itertools
from collections.abc import Sequence

import numpy as np

from dr_lab.diagnosis.faults.drive_fit import Forces
from dr_lab.diagnosis.faults.misread import Misreading, exchanged, exchanged_words, first_logs
from dr_lab.diagnosis.faults.smoothed_motion import smoothed_motion
from dr_lab.trajectory import Array, Log, MeasurementSet

_TINY = float(np.finfo(float).tiny)


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
    settings = forces.settings
    bad = [name for name, (left, need) in _left(forces).items() if left >= settings.share * need]
    if len(bad) < 2:
        return None
    motion = smoothed_motion(forces.model, measured, logs := first_logs(forces.logs, settings), settings.equation)
    given, found = _left(Forces.of(forces.model, logs, motion, settings)), []
    for pair in itertools.combinations(bad, 2):
        if _unit(forces.logs, pair[0]) != _unit(forces.logs, pair[1]):
            continue
        other = _left(Forces.of(forces.model, [exchanged(log, *pair) for log in logs], motion, settings))
        if {*pair} <= given.keys() & other.keys():
            found.append((max(other[name][0] / max(given[name][0], _TINY) for name in pair), pair))
    worst, pair = min(found, default=(np.inf, ("", "")))
    if worst > settings.contrast:
        return None
    told, remedy = exchanged_words(*pair)
    message = f"{told}: the other way round at most {100 * worst:.2g} % of the squares are left that are as declared."
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
