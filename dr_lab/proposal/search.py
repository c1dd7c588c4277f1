"""Which series is which joint's position, with which sign and in which unit.

The reading wins that leaves least to the equation of motion, and of those that it cannot tell apart the plainest.
"""

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.trial import Outcome, Reading
from dr_lab.proposal.zeros import OFFSETS

_FEW = 4  # joints whose signs are tried in all combinations
_UNUSUAL = 0.5  # cost of a unit other than SI, and of commands with an unusual gain
_MOUNTED = 1.0  # cost of a gyroscope that is mounted otherwise than in the model, as of a joint that counts otherwise
_BASES = 8  # readings without offsets that are tried with them

Readings = tuple[Reading, ...]


@dataclass(frozen=True)
class Options:
    """What a joint's position may be.

    Attributes:
        series: places among the candidates.
        units: factors to SI, the likeliest first.
        angle: whether it may count from another direction …
        felt: … and whether the equation of motion feels from which.
    """

    series: tuple[int, ...]
    units: tuple[float, ...]
    angle: bool
    felt: bool = True


@dataclass(frozen=True)
class Found:
    """The chosen reading.

    Attributes:
        readings: of each joint, in the model's order.
        outcome: it, tried.
        others: readings that explain the motion about as well.
        plain: those of them that are about as plain.
        plain_left: share of the squares that each of these leaves.
        turning: the joints whose zeros gyroscopes tell.
    """

    readings: Readings
    outcome: Outcome
    others: tuple[Readings, ...]
    plain: tuple[Readings, ...]
    plain_left: tuple[float, ...] = ()
    turning: frozenset[int] = frozenset()


class Turning(Protocol):
    """What tells of a reading by kinematics alone: gyroscopes (`dr_lab.proposal.gyros`)."""

    @property
    def joints(self) -> Sequence[int]:
        """The joints of which it tells."""
        ...

    def left(self, readings: Readings) -> float:
        """Share of the squares that a reading leaves."""
        ...

    def asked_for(self, options: Sequence[Options], readings: Readings) -> Readings | None:
        """The reading, found from another one, that it asks for; None where it tells nothing."""
        ...


def search(
    trial: Callable[[Readings], Outcome],
    options: Sequence[Options],
    cost: Callable[[Readings, Outcome], float],
    shown: Callable[[Readings, Outcome], bool],
    settings: ProposalSettings,
    gyros: Turning | None = None,
) -> Found:
    """Try readings, and choose.

    Args:
        trial: tries one.
        options: of each joint, in the model's order.
        cost: what speaks against a reading that explains the motion as well as others do.
        shown: whether the motion shows the offsets of a reading that has some.
        settings: how many are tried, and how close counts as equal.
        gyros: what they say of the joints goes before what forces say, if the model has some and the logs, too.
    """
    tried: dict[Readings, Outcome] = {}

    def outcome(readings: Readings) -> float:
        if readings not in tried:
            tried[readings] = trial(readings)
        return tried[readings].total

    for order in _orders(options, settings.most_orders):
        _signs_and_units(order, options, outcome)
    if len(options) > 1:
        _swaps(options, tried, outcome)
    turned = gyros.asked_for(options, min(tried, key=outcome)) if gyros else None
    if not gyros or not turned:
        return _chosen(_fitting(options, tried, outcome, shown, settings), cost, settings)
    outcome(turned)
    most = settings.near * gyros.left(turned) + settings.close
    told = _zeros_told(gyros, turned, most)
    untold = [replace(each, felt=each.felt and j not in told) for j, each in enumerate(options)]
    fitting = _fitting(untold, tried, outcome, shown, settings)
    agreeing = {r: each for r, each in {**fitting, turned: tried[turned]}.items() if gyros.left(r) <= most}
    confirmed = replace(_chosen(agreeing, cost, settings), turning=told)
    return _preferred(_chosen(fitting, cost, settings), confirmed, settings)


def _fitting(
    options: Sequence[Options],
    tried: dict[Readings, Outcome],
    total: Callable[[Readings], float],
    shown: Callable[[Readings, Outcome], bool],
    settings: ProposalSettings,
) -> dict[Readings, Outcome]:
    """What was tried, with offsets where none leaves little without; these count where weight shows them."""
    if _least(tried) > settings.well:
        _offsets(options, tried, total)
    fitting = _shown(tried, shown, settings)
    if _least(fitting) > settings.fits:
        fitting = {readings: each for readings, each in fitting.items() if not _moved(readings)}
    return fitting


def _least(tried: Mapping[Readings, Outcome]) -> float:
    """What the best reading leaves of the joint of which it leaves most."""
    return float(min(tried.values(), key=lambda each: each.total).left.max())


def _zeros_told(gyros: Turning, readings: Readings, most: float) -> frozenset[int]:
    """The joints that leave more than `most` when they count from any other direction."""
    others = {j: [each for each in (0.0, *OFFSETS) if each != readings[j].offset] for j in gyros.joints}
    lefts = {j: [gyros.left(_with(readings, j, offset=each)) for each in some] for j, some in others.items()}
    return frozenset(j for j, left in lefts.items() if min(left) > most)


def _chosen(
    tried: Mapping[Readings, Outcome], cost: Callable[[Readings, Outcome], float], settings: ProposalSettings
) -> Found:
    """The plainest of the readings that explain the motion about as well as the best."""
    near = _near(tried, settings)
    costs = {readings: _cost(readings) + cost(readings, tried[readings]) for readings in near}
    chosen = min(near, key=lambda readings: (costs[readings], tried[readings].total))
    others = tuple(readings for readings in near if readings != chosen)
    plain = tuple(readings for readings in others if costs[readings] <= costs[chosen] + _UNUSUAL)
    lefts = tuple(tried[readings].total for readings in plain)
    return Found(chosen, tried[chosen], others, plain, lefts)


def _preferred(found: Found, agreeing: Found, settings: ProposalSettings) -> Found:
    """What the gyroscopes say, unless it is plainer that they are mounted otherwise than in the model.

    Where both are as plain, the motion decides if it fits the one and not the other.
    """
    more = _cost(agreeing.readings) - _cost(found.readings) - _MOUNTED
    fits = float(found.outcome.left.max()) <= settings.well < settings.fits < float(agreeing.outcome.left.max())
    return found if more > 0 or (more == 0 and fits) else agreeing


def _cost(readings: Readings) -> float:
    """Turned signs, units other than SI, and offsets."""
    turned = sum(each.factor < 0 for each in readings)
    return turned + sum(_UNUSUAL * (abs(each.factor) != 1.0) + (each.offset != 0.0) for each in readings)


def _orders(options: Sequence[Options], most: int) -> Iterator[tuple[int, ...]]:
    """Assignments of different series to the joints; only the first where there are very many."""
    every = (order for order in itertools.product(*(each.series for each in options)) if len({*order}) == len(order))
    first = list(itertools.islice(every, most + 1))
    yield from first if len(first) <= most else first[:1]


def _signs_and_units(order: tuple[int, ...], options: Sequence[Options], total: Callable[[Readings], float]) -> None:
    """All signs of few joints, one after the other of many; units of all joints together, then each alone."""
    best: Readings = ()
    for place in range(max(len(each.units) for each in options)):
        units = [each.units[min(place, len(each.units) - 1)] for each in options]
        plain = tuple(Reading(k, unit) for k, unit in zip(order, units, strict=True))
        best = min((best or plain, _turned(plain, total)), key=total)
    for j, each in enumerate(options):
        for unit in each.units:
            tried = _with(best, j, factor=math.copysign(unit, best[j].factor))
            best = min(best, tried, key=total)


def _turned(readings: Readings, total: Callable[[Readings], float]) -> Readings:
    if len(readings) <= _FEW:
        signs = itertools.product((1, -1), repeat=len(readings))
        return min((_signed(readings, each) for each in signs), key=total)
    improved = True
    while improved:
        turns = [_with(readings, j, factor=-each.factor) for j, each in enumerate(readings)]
        best = min(turns, key=total)
        improved = total(best) < total(readings)
        readings = best if improved else readings
    return readings


def _swaps(options: Sequence[Options], tried: dict[Readings, Outcome], total: Callable[[Readings], float]) -> None:
    """Exchange the series of two joints as long as that leaves less, where they may be exchanged."""
    improved = True
    while improved:
        best = min(tried, key=total)
        for a, b in itertools.combinations(range(len(best)), 2):
            if best[b].series in options[a].series and best[a].series in options[b].series:
                swapped = _with(_with(best, a, series=best[b].series), b, series=best[a].series)
                _turned(swapped, total)
        improved = total(min(tried, key=total)) < total(best)


def _offsets(options: Sequence[Options], tried: dict[Readings, Outcome], total: Callable[[Readings], float]) -> None:
    """Angles that count from another direction: of each order and unit, of two joints together, else one by one."""
    best: dict[tuple[tuple[int, float], ...], Readings] = {}
    for readings in sorted(tried, key=total):
        best.setdefault(tuple((each.series, abs(each.factor)) for each in readings), readings)
    for readings in list(best.values())[:_BASES]:
        for offsets in _directions(options):
            moved = tuple(replace(each, offset=offset) for each, offset in zip(readings, offsets, strict=True))
            _turned(moved, total)


def _near(tried: Mapping[Readings, Outcome], settings: ProposalSettings) -> list[Readings]:
    """The readings that explain the motion about as well as the best; more of them where that does not fit either."""
    most = most_near(min(tried.values(), key=lambda each: each.total), settings)
    return [readings for readings, each in tried.items() if each.total <= most]


def most_near(best: Outcome, settings: ProposalSettings) -> float:
    """Share of the squares up to which a reading explains the motion about as well as the best."""
    fits = float(best.left.max()) <= settings.fits
    open_squares = min(best.total, settings.well) if fits else best.total
    return best.total + settings.close + (settings.near - 1) * open_squares


def _shown(
    tried: Mapping[Readings, Outcome], shown: Callable[[Readings, Outcome], bool], settings: ProposalSettings
) -> dict[Readings, Outcome]:
    """The readings without offsets, and those with offsets that leave less than these and are shown.

    Only those are asked that explain the motion about as well as the best.
    """
    kept = {readings: each for readings, each in tried.items() if not _moved(readings)}
    least = best = min(kept.values(), key=lambda each: each.total)
    moved = ((readings, each) for readings, each in tried.items() if _moved(readings) and each.total < least.total)
    for readings, each in sorted(moved, key=lambda pair: pair[1].total):
        if each.total > most_near(best, settings):
            break
        if shown(readings, each):
            kept[readings] = each
            best = min(best, each, key=lambda outcome: outcome.total)
    return kept


def _moved(readings: Readings) -> bool:
    return any(each.offset for each in readings)


def _directions(options: Sequence[Options]) -> Iterator[tuple[float, ...]]:
    """Offsets of all joints: each combination of two, and of more those that move one."""
    choices = [(0.0, *OFFSETS) if each.angle and each.felt else (0.0,) for each in options]
    every = itertools.product(*choices)
    yield from (each for each in every if len(options) <= 2 or sum(offset != 0.0 for offset in each) == 1)


def _with(readings: Readings, joint: int, **changes: float) -> Readings:
    changed = replace(readings[joint], **changes)  # pyright: ignore[reportArgumentType]
    return (*readings[:joint], changed, *readings[joint + 1 :])


def _signed(readings: Readings, signs: Sequence[int]) -> Readings:
    return tuple(replace(each, factor=sign * each.factor) for each, sign in zip(readings, signs, strict=True))


def ambiguous(found: Found) -> list[tuple[int, ...]]:
    """The sets of joints whose signs may be turned together without leaving much more."""
    sets = set()
    for other in found.others:
        if all(
            a.series == b.series and abs(a.factor) == abs(b.factor) for a, b in zip(found.readings, other, strict=True)
        ):
            turned = tuple(
                int(j)
                for j in np.flatnonzero([a.factor != b.factor for a, b in zip(found.readings, other, strict=True)])
            )
            sets.add(turned)
    return sorted(sets - {()})
