"""Commands that a motion follows rather as lines between their samples than as steps."""

import math
from collections import defaultdict

from dr_lab.diagnosis.faults.drive_fit import Forces
from dr_lab.diagnosis.faults.fault_settings import FaultSettings
from dr_lab.trajectory import MeasurementSet

_LEAST = 1e-300  # of squares, so that a perfect reading has a logarithm


def may_follow_lines(forces: Forces | None, measured: MeasurementSet, settings: FaultSettings) -> tuple[str, ...]:
    """Actuators whose commands may have changed between their samples: all whose samples are rare, or none.

    Commands of which the measurements say what they did between their samples (`Signal.between`) are left out.

    Commands of one machine come from one controller and one logger. So they are read in one way, the likelier
    one: of residuals of unknown size, n test functions of an actuator in a log add n/2 log(held / line) to the
    log-likelihood of lines, by the squares that the two readings leave. It is a suspicion, no proof: friction or
    inertia that the model lacks beyond `FaultSettings.wrong` may look like a shift in time. Where the equation of
    motion cannot be tested, all whose samples are coarse (`FaultSettings.is_coarse`) are suspected.

    Args:
        forces: of all logs, by the model as given; None where nothing can be tested.
        measured: all logs.
        settings: thresholds.

    Source:
        profile likelihood over the scale, Pawitan, In All Likelihood (2001), section 3.4.
    """
    if forces is None:
        logs = (*measured.fit, *measured.held_out)
        sent = ((name, signal) for log in logs for name, signal in log.commands.items() if signal.between == "")
        return tuple(dict.fromkeys(name for name, signal in sent if settings.is_coarse(signal.wait)))
    bounds, gained = (settings.gain, 1 / settings.gain), defaultdict[str, float](float)
    for fit in forces.drives():
        if fit.straight is not None and fit.log.commands[fit.actuator].between == "":
            held, line = (max(fit.gain(*bounds, drive=drive).left, _LEAST) for drive in (fit.drive, fit.straight))
            gained[fit.actuator] += len(fit.time) / 2 * math.log(held / line)
    return tuple(gained) if sum(gained.values()) > 0 else ()
