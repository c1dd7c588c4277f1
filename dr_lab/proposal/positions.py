"""The joints' positions found among the series of the logs."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from dr_lab.errors import DataError
from dr_lab.proposal.by_name import matches, say_same
from dr_lab.proposal.drives import UNITS, Drive, drives_of
from dr_lab.proposal.grid import Grid, grid_of, held_of, path_of, wrapped
from dr_lab.proposal.search import Found, Options, Readings, ambiguous, search
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.survey import Series, Survey
from dr_lab.proposal.trial import Outcome, Trial, per_control

_ANGLES, _LENGTHS = UNITS["rad"], UNITS["m"]
_UNUSUAL = 0.5  # cost of a command whose gain is that of no unit
_HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)
_FREE = mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT


@dataclass(frozen=True)
class Position:
    """A proposed output.

    Attributes:
        channel: ``<joint>.position`` or ``<joint>.velocity``.
        series: what holds it.
        unit: of its numbers.
        sign: +1 or −1.
        offset: in that unit.
        wrap: whether the numbers jump by full turns.
        why: what speaks for it.
    """

    channel: str
    series: Series
    unit: str
    sign: int
    offset: float
    wrap: bool
    why: str


@dataclass(frozen=True)
class Positions:
    """What is known of the joints' positions.

    Attributes:
        outputs: found, in the model's order.
        found: the reading that the equation of motion chose; None where it could not be tested.
        trial: what it was chosen with; None likewise.
        commands: series that may be commands; the drives of the trial.
        drives: actuators that they may command.
        doubts: what is unsure, a sentence each.
    """

    outputs: tuple[Position, ...]
    found: Found | None
    trial: Trial | None
    commands: tuple[Series, ...]
    drives: tuple[Drive, ...]
    doubts: tuple[str, ...]


def find_positions(model: mujoco.MjModel, logs: Survey, settings: ProposalSettings) -> Positions:
    """Find the joints' positions by name and, where all joints can be measured, by the equation of motion.

    Args:
        model: compiled, the caller's own.
        logs: what the logs hold.
        settings: thresholds.

    Raises:
        DataError: no series fits a joint, or none of the readings is one of this robot.
    """
    model = unhindered(model)
    joints = [model.joint(i).name for i in range(model.njnt)]
    named = [s for s in logs.named("position") if s.moves]
    unnamed = [] if len(named) >= len(joints) else _no_velocities([s for s in logs.named("") if s.moves], settings)
    candidates = [*named, *unnamed]
    scalar = bool((model.jnt_type == _HINGE).all() or model.nv == model.njnt == model.nq)
    allowed = matches(joints, candidates)
    assignable = len({k for each in allowed for k in each}) >= len(joints) and all(allowed)
    asked = [s for s in (*logs.named("drive"), *logs.named("reference"), *unnamed) if s.moves]
    if not (scalar and assignable):
        return _by_name(model, logs, candidates, asked)
    grid = grid_of([*candidates, *asked], settings)
    force, biased = per_control(model)
    drives = drives_of(model, force)
    trial = _trial(model, grid, candidates, asked, drives, settings, biased=biased)
    options = [
        Options(tuple(each), _units(model, j, [candidates[k] for k in each]), bool(model.jnt_type[j] == _HINGE))
        for j, each in enumerate(allowed)
    ]
    found = search(trial, options, lambda outcome: _cost(outcome, drives, asked, settings), settings)
    by_words = say_same(joints, candidates)
    outputs = tuple(_position(model, j, found, candidates, by_words=by_words) for j in range(len(joints)))
    doubts = _doubts(joints, found, candidates, settings, by_words=by_words)
    return Positions(outputs, found, trial, tuple(asked), drives, tuple(doubts))


def unhindered(model: mujoco.MjModel) -> mujoco.MjModel:
    """The caller's own model without contacts and without ends of joints, which a wrong reading would run into."""
    model.opt.disableflags |= int(_FREE)
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


def _units(model: mujoco.MjModel, j: int, series: Sequence[Series]) -> tuple[float, ...]:
    """Factors to SI that a joint's series may have: that of the name, or all."""
    known = _ANGLES if model.jnt_type[j] == _HINGE else _LENGTHS
    said = {s.words.unit for s in series}
    if said <= {*known}:
        return tuple(known[unit] for unit in known if unit in said)
    return tuple(known.values())


def _cost(outcome: Outcome, drives: Sequence[Drive], asked: Sequence[Series], settings: ProposalSettings) -> float:
    """Commands that act against their sign, or with the gain of no unit that their name may mean."""
    cost = 0.0
    for drive in drives:
        if not outcome.given[drive.dof]:
            continue
        given = outcome.given[drive.dof][0]
        gain = given.gain / (given.stiffness or drive.force)
        factor = UNITS.get(drive.unit, {}).get(asked[given.series].words.unit, 1.0)
        usual = settings.gain < abs(gain) / factor < 1 / settings.gain
        cost += (gain < 0) + _UNUSUAL * (not usual)
    return cost


def _position(model: mujoco.MjModel, j: int, found: Found, candidates: Sequence[Series], *, by_words: bool) -> Position:
    reading = found.readings[j]
    series, factor = candidates[reading.series], abs(reading.factor)
    known = _ANGLES if model.jnt_type[j] == _HINGE else _LENGTHS
    unit = min(known, key=lambda name: abs(known[name] - factor))
    left = float(found.outcome.left[model.jnt_dofadr[j]])
    how = "by its name" if by_words else "by the motion"
    why = f"{how}; the equation of motion leaves {left:.1%}"
    wrap = any(wrapped(signal.value) > 0 for signal in series.signals)
    sign = 1 if reading.factor > 0 else -1
    return Position(f"{model.joint(j).name}.position", series, unit, sign, reading.offset / factor, wrap, why)


def _doubts(
    joints: Sequence[str],
    found: Found,
    candidates: Sequence[Series],
    settings: ProposalSettings,
    *,
    by_words: bool,
) -> list[str]:
    """What the equation of motion leaves open."""
    left = float(found.outcome.left.max())
    if left > settings.fits and not by_words:
        raise DataError(
            f"No reading of {', '.join(str(each.place) for each in candidates)} moves as {', '.join(joints)} do: the "
            f"best leaves {left:.0%} of a joint's forces unexplained. Are these logs of this robot? If so, "
            "name columns or topics after the joints (elbow_position), or write the measurements by hand."
        )
    doubts = []
    if left > settings.fits:
        doubts.append(
            f"With these names the equation of motion leaves {left:.0%} of a joint's forces unexplained: the logs may "
            "be of another robot, the masses far off, or a force missing that the model knows nothing of."
        )
    elif left > settings.well:
        doubts.append(
            f"The best reading leaves {left:.0%} of a joint's forces unexplained: an angle may be read wrongly "
            "(absolute where the model's is relative, another zero), or a mass be far off."
        )
    turned = any(each.factor < 0 for each in found.readings) or any(
        given[0].gain < 0 for given in found.outcome.given if given
    )
    sets = ambiguous(found)
    if sets and turned:
        listed = "; ".join(" and ".join(joints[j] for j in each) for each in sets)
        doubts.append(f"As good with the signs of {listed} turned, each with those of its commands: check one joint's.")
    if any(_different(found.readings, other) for other in found.plain):
        doubts.append(f"As good in another order: {_orders(found, joints, candidates)}. Name columns after the joints.")
    degrees = {
        j for other in found.plain for j, (a, b) in enumerate(zip(found.readings, other, strict=True))
        if abs(a.factor) != abs(b.factor) and a.series == b.series
    }  # fmt: skip
    if degrees:
        listed = ", ".join(joints[j] for j in sorted(degrees))
        doubts.append(f"The unit of {listed} is not seen in the motion: another would fit about as well.")
    moved = [joints[j] for j, each in enumerate(found.readings) if each.offset]
    if moved:
        doubts.append(f"{', '.join(moved)} count from another direction than in the model: offsets were added.")
    return doubts


def _different(a: Readings, b: Readings) -> bool:
    return any(x.series != y.series for x, y in zip(a, b, strict=True))


def _orders(found: Found, joints: Sequence[str], candidates: Sequence[Series]) -> str:
    other = next(each for each in found.plain if _different(found.readings, each))
    return ", ".join(f"{joint} = {candidates[r.series].place}" for joint, r in zip(joints, other, strict=True))


def _no_velocities(series: list[Series], settings: ProposalSettings) -> list[Series]:
    """The series that are not the derivative of another."""
    if len(series) < 2:
        return series
    grid = grid_of(series, settings)
    paths = [path_of(each, grid, settings.cutoff) for each in series]
    slopes, values = (np.stack([getattr(path, name) for path in paths]) for name in ("slope", "value"))
    slopes = slopes - slopes.mean(1, keepdims=True)
    values = values - values.mean(1, keepdims=True)
    norms = np.outer(np.linalg.norm(slopes, axis=1), np.linalg.norm(values, axis=1))
    alike = np.abs(slopes @ values.T) / np.where(norms == 0, np.inf, norms)
    return [each for k, each in enumerate(series) if alike[:, k].max() < settings.derivative]


def _by_name(model: mujoco.MjModel, logs: Survey, candidates: Sequence[Series], asked: Sequence[Series]) -> Positions:
    """What the names alone say."""
    names = [model.joint(i).name for i in range(model.njnt) if model.jnt_type[i] >= int(mujoco.mjtJoint.mjJNT_SLIDE)]
    velocities = [s for s in logs.named("velocity") if s.moves]
    outputs = []
    lacking = []
    for j, name in enumerate(names):
        place, rate = matches(names, candidates)[j], matches(names, velocities)[j]
        hinge = model.jnt_type[model.joint(name).id] == _HINGE
        if len(place) == 1:
            outputs.append(_named(f"{name}.position", candidates[place[0]], "rad" if hinge else "m"))
        elif len(rate) == 1:
            outputs.append(_named(f"{name}.velocity", velocities[rate[0]], "rad/s" if hinge else "m/s"))
        else:
            lacking.append(name)
    if not outputs:
        seen = [str(each.place) for each in logs.series]
        raise DataError(
            f"No series of the logs fits a joint of the robot. Joints: {', '.join(names)}. The logs hold "
            f"{', '.join(seen[:20])}{' …' if len(seen) > 20 else ''}. Are these logs of this robot? If so, name "
            "columns or topics after the joints (elbow_position), or write the measurements by hand."
        )
    doubts = [f"Signs and units are by name alone: {_why_untested(model, lacking)}."]
    if lacking:
        doubts.append(f"No series is said to be {', '.join(lacking)}: not measured, or called differently.")
    force, _ = per_control(model)
    return Positions(tuple(outputs), None, None, tuple(asked), drives_of(model, force), tuple(doubts))


def _named(channel: str, series: Series, usual: str) -> Position:
    wrap = any(wrapped(signal.value) > 0 for signal in series.signals)
    unit = series.words.unit or _by_range(series, usual)
    return Position(channel, series, unit, 1, 0.0, wrap, "by its name")


def _by_range(series: Series, usual: str) -> str:
    """Degrees where the numbers are too large for radians: more than two turns."""
    largest = max(float(np.ptp(signal.value)) for signal in series.signals)
    return "deg" if usual == "rad" and largest > 4 * math.pi else usual


def _why_untested(model: mujoco.MjModel, lacking: Sequence[str]) -> str:
    if lacking:
        return "not every joint is measured, which inverse dynamics needs"
    return "a joint is neither a hinge nor a slide" if model.nv != model.njnt else "the names leave too much open"
