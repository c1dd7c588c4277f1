"""What speaks against a reading of the logs that explains the motion as well as others do."""

from collections.abc import Sequence

import mujoco
import numpy as np

from dr_lab.proposal.command_units import factors
from dr_lab.proposal.drives import Drive
from dr_lab.proposal.search import Readings
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.settled import Rests
from dr_lab.proposal.survey import Series
from dr_lab.proposal.trial import Outcome, Trial

_BEYOND = 0.02  # rad or m, of a joint's range, by which its stop may give way
_UNUSUAL = 0.5  # cost of a command whose gain is that of no unit
_HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)


def of_command(
    drive: Drive,
    readings: Readings,
    outcome: Outcome,
    asked: Sequence[Series],
    rests: Rests,
    settings: ProposalSettings,
) -> float:
    """What speaks against a command that acts against its sign, or with the gain of no unit that its name may mean.

    Where its joint comes to rest at it, that says which gain it should have.
    """
    if not outcome.given[drive.dof]:
        return 0.0
    given = outcome.given[drive.dof][0]
    gain = given.gain / (given.stiffness or drive.force)
    reading = readings[drive.dof]
    rest = rests.get((reading.series, given.series)) if drive.servo or given.stiffness > 0 else None
    unit = asked[given.series].words.unit
    factor = factors(drive.unit, unit).get(unit, 1.0) if rest is None else reading.factor * rest.ratio
    usual = settings.gain < abs(gain / factor) < 1 / settings.gain
    return (gain / factor < 0) + _UNUSUAL * (not usual)


def beyond(model: mujoco.MjModel, trial: Trial, readings: Readings) -> dict[str, tuple[float, float]]:
    """The joints that a reading moves beyond their range in the model, each with where it moves them."""
    found = {}
    for i, reading in enumerate(readings):
        if reading.series in trial.rates:  # nobody knows where it began
            continue
        low, high = model.jnt_range[i]
        place = reading.factor * trial.candidates[reading.series].value + reading.offset
        if model.jnt_limited[i] and (place.min() < low - _BEYOND or place.max() > high + _BEYOND):
            found[model.joint(i).name] = (float(place.min()), float(place.max()))
    return found


def too_fast(model: mujoco.MjModel, trial: Trial, readings: Readings, limit: float) -> int:
    """How many hinges a reading turns faster than a limit in rad/s."""
    speeds = [float(np.abs(each.factor * trial.candidates[each.series].slope).max()) for each in readings]
    return sum(speed > limit for speed, kind in zip(speeds, model.jnt_type, strict=True) if kind == _HINGE)
