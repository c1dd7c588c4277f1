"""The joints' positions found among the series of the logs."""

from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import replace

import mujoco

from dr_lab.diagnosis.windows.closed_loops import coupled
from dr_lab.errors import DataError
from dr_lab.proposal.by_name import say_same
from dr_lab.proposal.by_name_alone import positions_by_name
from dr_lab.proposal.command_units import factors
from dr_lab.proposal.counts import counted_by_name, with_counts
from dr_lab.proposal.doubts import doubts_of, require_fit
from dr_lab.proposal.drives import drives_of
from dr_lab.proposal.grid import wrapped
from dr_lab.proposal.jumping import jumps
from dr_lab.proposal.lengths import joints_may_be
from dr_lab.proposal.mounting import worn
from dr_lab.proposal.output import Output, Positions
from dr_lab.proposal.per_control import per_control
from dr_lab.proposal.search import Options
from dr_lab.proposal.searched import Searched
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.settled import all_rests, unit_by_rests
from dr_lab.proposal.survey import Series, Survey
from dr_lab.proposal.tries import Tries
from dr_lab.proposal.velocities import may_be_rate, no_velocities
from dr_lab.proposal.zeros import felt_zeros

_HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)
_FREE = mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT | mujoco.mjtDisableBit.mjDSBL_CLAMPCTRL


def find_positions(
    model: mujoco.MjModel, logs: Survey, settings: ProposalSettings, sensed: Sequence[Output] = ()
) -> Positions:
    """Find the joints' positions by name and, where all joints can be measured, by the equation of motion.

    Args:
        model: compiled, the caller's own.
        logs: what the logs hold.
        settings: thresholds.
        sensed: what sensors read of the logs, so that no joint needs to; gyroscopes tell of the joints.

    Raises:
        DataError: no series fits a joint, or none of the readings is one of this robot.
    """
    model = unhindered(model)
    tries = Tries(model, worn(model, sensed), settings)
    joints = [model.joint(i).name for i in range(model.njnt)]
    named, nameless = ([s for s in logs.named(kind) if s.moves] for kind in ("position", ""))
    unnamed = [] if len(named) >= len(joints) else no_velocities(nameless, nameless, settings)
    candidates = [*named, *(each for each in unnamed if not jumps(each, settings))]
    scalar = bool((model.jnt_type == _HINGE).all() or model.nv == model.njnt == model.nq) and not coupled(model)
    allowed, by_words = joints_may_be(model, joints, candidates), say_same(joints, candidates)
    assignable = len({k for each in allowed for k in each}) >= len(joints) and all(allowed)
    asked = [*_commanding(model, logs), *unnamed]
    if scalar and not (assignable and (named or _integrals(logs, unnamed, settings))):
        found = _by_velocities(tries, logs, asked)
        if found is not None:
            return found
    if not (scalar and assignable):
        found = positions_by_name(model, logs, candidates, asked, sensed=bool(sensed))
        return replace(found, outputs=tuple(counted_by_name(each, settings) for each in found.outputs))
    options = _options(model, allowed, candidates, asked, settings)
    searched, counted = _tried(tries, candidates, asked, options, [] if unnamed else nameless)
    if not (by_words or len(joints) == len(candidates) == 1):
        require_fit(joints, searched, candidates, logs, settings)
    return _positions(model, searched, candidates, settings, by_words=by_words, counted=counted)


def _tried(
    tries: Tries,
    candidates: Sequence[Series],
    asked: Sequence[Series],
    options: Sequence[Options],
    nameless: Sequence[Series],
) -> tuple[Searched, Set[int]]:
    """The reading that fits best, with nameless commands, velocities and counts where these fit; joints in counts."""
    searched = tries.search(candidates, asked, options)
    if nameless and searched.lacks_command(tries.settings):
        searched = _with_nameless(tries, candidates, searched, nameless, options)
    searched = _with_velocities(tries, candidates, searched, options)
    return with_counts(
        [bool(kind == _HINGE) for kind in tries.model.jnt_type],
        candidates,
        searched,
        lambda narrow: tries.search(candidates, searched.asked, narrow, rates=searched.trial.rates),
        tries.settings,
    )


def _commanding(model: mujoco.MjModel, logs: Survey) -> list[Series]:
    """The series that move and are commands by their names; velocities where an actuator's control is one."""
    rate = any(drive.rate for drive in drives_of(model, per_control(model)[0]))
    named = (*logs.named("drive"), *logs.named("reference"), *(logs.named("asked velocity") if rate else ()))
    return [each for each in named if each.moves]


def _positions(
    model: mujoco.MjModel,
    searched: Searched,
    candidates: Sequence[Series],
    settings: ProposalSettings,
    *,
    by_words: bool,
    counted: Set[int] = frozenset(),
) -> Positions:
    joints = [model.joint(i).name for i in range(model.njnt)]
    read = (_output(model, j, searched, candidates, by_words=by_words) for j in range(len(joints)))
    outputs = tuple(
        replace(output, counts=tuple(settings.counts) if j in counted else ()) for j, output in enumerate(read)
    )
    doubts = doubts_of(joints, searched.found, candidates, settings)
    return Positions(outputs, searched.found, searched.trial, searched.asked, searched.drives, doubts, searched.gyros)


def _integrals(logs: Survey, nameless: Sequence[Series], settings: ProposalSettings) -> bool:
    """Whether nameless series may be positions beside velocities that are named: whether one changes as they say."""
    rates = [s for s in logs.named("velocity") if s.moves]
    return not rates or len(no_velocities(rates, nameless, settings)) < len(rates)


def _by_velocities(tries: Tries, logs: Survey, asked: Sequence[Series]) -> Positions | None:
    """The joints' velocities where no series may be their positions; None unless the motion is that of the robot."""
    model, settings = tries.model, tries.settings
    joints = [model.joint(i).name for i in range(model.njnt)]
    rates = [s for s in logs.named("velocity") if s.moves]
    allowed = joints_may_be(model, joints, rates)
    if not all(allowed) or len({k for each in allowed for k in each}) < len(joints):
        return None
    options = _options(model, allowed, rates, (), settings, rates=range(len(rates)))
    try:
        searched = tries.search(rates, asked, options, rates=range(len(rates)))
    except DataError:  # no log is long enough
        return None
    if float(searched.found.outcome.left.max()) > settings.fits:
        return None
    return _positions(model, searched, rates, settings, by_words=say_same(joints, rates))


def _with_velocities(
    tries: Tries, candidates: Sequence[Series], searched: Searched, options: Sequence[Options]
) -> Searched:
    """The search with series as velocities that explain nothing as positions, where they then do; else as it was.

    A name that says a position, or its unit, is believed, and so is a rest where a command would have a position.
    """
    settings, readings, outcome = tries.settings, searched.found.readings, searched.found.outcome
    bad = [j for j, reading in enumerate(readings) if outcome.left[j] > settings.nothing]
    rates = [k for j in bad if may_be_rate(candidates[k := readings[j].series])]
    asked = [each for each in searched.asked if each.words.kind not in ("drive", "asked velocity")]
    rests = all_rests([candidates[k] for k in rates], asked, settings).values()
    if not rates or len(rates) < len(bad) or any(rest.passes_for(1.0, settings) for rest in rests):
        return searched
    kept = [each for each in searched.asked if all(each is not candidates[k] for k in rates)]
    places = [(reading.series,) for reading in readings]
    narrow = [
        turned if j in bad else replace(each, series=place)
        for j, (place, each, turned) in enumerate(
            zip(places, options, _options(tries.model, places, candidates, (), settings, rates=rates), strict=True)
        )
    ]
    found = tries.search(candidates, kept, narrow, rates=rates)
    return found if float(found.found.outcome.left[bad].max()) <= settings.fits else searched


def _with_nameless(
    tries: Tries,
    candidates: Sequence[Series],
    searched: Searched,
    nameless: Sequence[Series],
    options: Sequence[Options],
) -> Searched:
    """The search with series as commands whose names say nothing, where one of them explains a motion; else as it was.

    Velocities are none: they would do what a damping does.
    """
    try:
        spare = no_velocities(nameless, candidates, tries.settings)
        wider = tries.search(candidates, [*searched.asked, *spare], options)
    except DataError:  # they share no time with the positions
        return searched
    return wider if wider.explained_by(spare, tries.settings) else replace(searched, vain=tuple(spare))


def _options(
    model: mujoco.MjModel,
    allowed: Sequence[Sequence[int]],
    candidates: Sequence[Series],
    asked: Sequence[Series],
    settings: ProposalSettings,
    *,
    rates: Collection[int] = (),
) -> list[Options]:
    """What each joint's position may be, or its velocity where a series is one."""
    found, felt = [], felt_zeros(model)
    for j, each in enumerate(allowed):
        rate, angle = bool({*each} & {*rates}), bool(model.jnt_type[j] == _HINGE)
        series = [candidates[k] for k in each]
        known = _known(model, j, series, rate=rate)
        said = {s.words.unit or unit_by_rests(s, asked, known, settings) for s in series}
        found.append(Options(tuple(each), _units(said, known), angle and not rate, felt[j]))
    return found


def _known(model: mujoco.MjModel, j: int, series: Sequence[Series], *, rate: bool) -> Mapping[str, float]:
    """Sizes of the units that a joint's position or velocity may have: the usual ones, and others that names say."""
    unit = "rad" if model.jnt_type[j] == _HINGE else "m"
    base = f"{unit}/s" if rate else unit
    return {name: factor for each in series for name, factor in factors(base, each.words.unit).items()}


def unhindered(model: mujoco.MjModel) -> mujoco.MjModel:
    """The caller's own model without contacts, ends of joints and limits of forces: a wrong reading would meet them.

    A servo's force is looked at with and without its command, and each of them alone may be far beyond what both make.
    """
    model.opt.disableflags |= int(_FREE)
    for limited in (model.actuator_forcelimited, model.jnt_actfrclimited, model.tendon_actfrclimited):
        limited[:] = 0
    return model


def _units(said: Set[str], known: Mapping[str, float]) -> tuple[float, ...]:
    """Factors to SI that a joint's series may have: those that are said, or all."""
    return tuple(factor for unit, factor in known.items() if unit in said or not said <= {*known})


def _output(
    model: mujoco.MjModel, j: int, searched: Searched, candidates: Sequence[Series], *, by_words: bool
) -> Output:
    found = searched.found
    reading = found.readings[j]
    series, factor, rate = candidates[reading.series], abs(reading.factor), reading.series in searched.trial.rates
    known = _known(model, j, [series], rate=rate)
    unit = min(known, key=lambda name: abs(known[name] - factor))
    scale = float(f"{factor / known[unit]:.9g}")
    left = float(found.outcome.left[model.jnt_dofadr[j]])
    how = "by its name" if by_words else "by the motion"
    why = f"{how}; the equation of motion leaves {left:.1%}"
    if rate and series.words.kind != "velocity":
        why += ", and hardly less than all if this were the position"
    wrap = not rate and any(wrapped(signal.value) > 0 for signal in series.signals)
    sign, what = 1 if reading.factor > 0 else -1, "velocity" if rate else "position"
    return Output(
        f"{model.joint(j).name}.{what}", (series,), unit, sign, reading.offset / known[unit], wrap, why, scale
    )
