"""The joints' positions found among the series of the logs."""

from collections.abc import Mapping, Sequence, Set
from dataclasses import replace

import mujoco

from dr_lab.errors import DataError
from dr_lab.proposal.by_name import say_same
from dr_lab.proposal.by_name_alone import positions_by_name
from dr_lab.proposal.doubts import doubts_of, require_fit
from dr_lab.proposal.drives import UNITS, Drive, drives_of, factors
from dr_lab.proposal.grid import Grid, grid_of, held_of, path_of, wrapped
from dr_lab.proposal.lengths import joints_may_be
from dr_lab.proposal.output import Output, Positions
from dr_lab.proposal.search import Found, Options, Readings, search
from dr_lab.proposal.searched import Searched
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.settled import Rests, all_rests, unit_by_rests
from dr_lab.proposal.survey import Series, Survey
from dr_lab.proposal.trial import Outcome, Trial, per_control
from dr_lab.proposal.velocities import no_velocities
from dr_lab.proposal.weight import shown_by_weight

_ANGLES, _LENGTHS = UNITS["rad"], UNITS["m"]
_BEYOND = 0.02  # rad or m, of a joint's range, by which its stop may give way
_UNUSUAL = 0.5  # cost of a command whose gain is that of no unit
_HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)
_FREE = mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT | mujoco.mjtDisableBit.mjDSBL_CLAMPCTRL


def find_positions(
    model: mujoco.MjModel, logs: Survey, settings: ProposalSettings, *, sensed: bool = False
) -> Positions:
    """Find the joints' positions by name and, where all joints can be measured, by the equation of motion.

    Args:
        model: compiled, the caller's own.
        logs: what the logs hold.
        settings: thresholds.
        sensed: whether sensors read something of the logs, so that no joint needs to.

    Raises:
        DataError: no series fits a joint, or none of the readings is one of this robot.
    """
    model = unhindered(model)
    joints = [model.joint(i).name for i in range(model.njnt)]
    named, nameless = ([s for s in logs.named(kind) if s.moves] for kind in ("position", ""))
    unnamed = [] if len(named) >= len(joints) else no_velocities(nameless, nameless, settings)
    candidates = [*named, *unnamed]
    scalar = bool((model.jnt_type == _HINGE).all() or model.nv == model.njnt == model.nq)
    allowed, by_words = joints_may_be(model, joints, candidates), say_same(joints, candidates)
    assignable = len({k for each in allowed for k in each}) >= len(joints) and all(allowed)
    asked = [s for s in (*logs.named("drive"), *logs.named("reference"), *unnamed) if s.moves]
    if not (scalar and assignable):
        return positions_by_name(model, logs, candidates, asked, sensed=sensed)
    options = _options(model, allowed, candidates, asked, settings)
    searched = _searched(model, candidates, asked, options, settings)
    if nameless and not unnamed and searched.lacks_command(settings):
        searched = _with_nameless(model, candidates, searched, nameless, options, settings)
    found = searched.found
    outputs = tuple(_position(model, j, found, candidates, by_words=by_words) for j in range(len(joints)))
    if not (by_words or len(joints) == len(candidates) == 1):
        require_fit(joints, searched, candidates, logs, settings)
    return Positions(
        outputs, found, searched.trial, searched.asked, searched.drives, doubts_of(joints, found, candidates, settings)
    )


def _with_nameless(
    model: mujoco.MjModel,
    candidates: Sequence[Series],
    searched: Searched,
    nameless: Sequence[Series],
    options: Sequence[Options],
    settings: ProposalSettings,
) -> Searched:
    """The search with series as commands whose names say nothing, where one of them explains a motion; else as it was.

    Velocities are none: they would do what a damping does.
    """
    try:
        spare = no_velocities(nameless, candidates, settings)
        wider = _searched(model, candidates, [*searched.asked, *spare], options, settings)
    except DataError:  # they share no time with the positions
        return searched
    return wider if wider.explained_by(spare, settings) else replace(searched, vain=tuple(spare))


def _searched(
    model: mujoco.MjModel,
    candidates: Sequence[Series],
    asked: Sequence[Series],
    options: Sequence[Options],
    settings: ProposalSettings,
) -> Searched:
    """The reading of the candidates that fits best, with such series as may be commands."""
    grid = grid_of([*candidates, *asked], settings)
    force, biased = per_control(model)
    drives = drives_of(model, force)
    rests = all_rests(candidates, asked, settings) if any(each.servo or each.added for each in drives) else {}
    trial = _trial(model, grid, candidates, asked, drives, settings, biased=biased)
    found = search(
        trial,
        options,
        lambda readings, outcome: (
            sum(_cost(drive, readings, outcome, asked, rests, settings) for drive in drives)
            + len(beyond(model, trial, readings))
        ),
        lambda readings: shown_by_weight(trial, readings, settings),
        settings,
    )
    return Searched(trial, found, tuple(asked), drives)


def _options(
    model: mujoco.MjModel,
    allowed: Sequence[Sequence[int]],
    candidates: Sequence[Series],
    asked: Sequence[Series],
    settings: ProposalSettings,
) -> list[Options]:
    """What each joint's position may be."""
    found = []
    for j, each in enumerate(allowed):
        angle = bool(model.jnt_type[j] == _HINGE)
        known = _ANGLES if angle else _LENGTHS
        series = [candidates[k] for k in each]
        said = {s.words.unit or unit_by_rests(s, asked, known, settings) for s in series}
        found.append(Options(tuple(each), _units(said, known), angle))
    return found


def unhindered(model: mujoco.MjModel) -> mujoco.MjModel:
    """The caller's own model without contacts, ends of joints and limits of forces: a wrong reading would meet them.

    A servo's force is looked at with and without its command, and each of them alone may be far beyond what both make.
    """
    model.opt.disableflags |= int(_FREE)
    for limited in (model.actuator_forcelimited, model.jnt_actfrclimited, model.tendon_actfrclimited):
        limited[:] = 0
    return model


def _trial(
    model: mujoco.MjModel,
    grid: Grid,
    candidates: Sequence[Series],
    asked: Sequence[Series],
    drives: Sequence[Drive],
    settings: ProposalSettings,
    *,
    biased: bool,
) -> Trial:
    moved = {drive.dof for drive in drives}
    return Trial(
        model=model,
        grid=grid,
        candidates=tuple(path_of(each, grid, settings.cutoff) for each in candidates),
        drives=tuple(tuple(held_of(each, grid, lag) for lag in settings.lags) for each in asked),
        lags=settings.lags,
        servos=tuple(model.nu == 0 and each.words.kind != "drive" for each in asked),
        driven=tuple(dof in moved for dof in range(model.nv)),
        biased=biased,
    )


def _units(said: Set[str], known: Mapping[str, float]) -> tuple[float, ...]:
    """Factors to SI that a joint's series may have: those that are said, or all."""
    return tuple(factor for unit, factor in known.items() if unit in said or not said <= {*known})


def _cost(
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
        low, high = model.jnt_range[i]
        place = reading.factor * trial.candidates[reading.series].value + reading.offset
        if model.jnt_limited[i] and (place.min() < low - _BEYOND or place.max() > high + _BEYOND):
            found[model.joint(i).name] = (float(place.min()), float(place.max()))
    return found


def _position(model: mujoco.MjModel, j: int, found: Found, candidates: Sequence[Series], *, by_words: bool) -> Output:
    reading = found.readings[j]
    series, factor = candidates[reading.series], abs(reading.factor)
    known = _ANGLES if model.jnt_type[j] == _HINGE else _LENGTHS
    unit = min(known, key=lambda name: abs(known[name] - factor))
    left = float(found.outcome.left[model.jnt_dofadr[j]])
    how = "by its name" if by_words else "by the motion"
    why = f"{how}; the equation of motion leaves {left:.1%}"
    wrap = any(wrapped(signal.value) > 0 for signal in series.signals)
    sign = 1 if reading.factor > 0 else -1
    return Output(f"{model.joint(j).name}.position", (series,), unit, sign, reading.offset / factor, wrap, why)
