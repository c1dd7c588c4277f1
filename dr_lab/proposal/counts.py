"""Angles and lengths that may be counts of an encoder: whole numbers whose name says no unit."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from dr_lab.proposal.command_units import UNITS
from dr_lab.proposal.drives import explains
from dr_lab.proposal.output import Output
from dr_lab.proposal.search import Options, Readings, most_near
from dr_lab.proposal.searched import Searched
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.settled import settled
from dr_lab.proposal.survey import Series
from dr_lab.trajectory import Array

Again = Callable[[Sequence[Options]], Searched]


def may_be_counts(series: Series) -> bool:
    """Whether a series holds whole numbers alone, and its name says no unit."""
    return not series.words.unit and all(_whole(signal.value) for signal in series.signals)


def with_counts(
    hinges: Sequence[bool], candidates: Sequence[Series], searched: Searched, again: Again, settings: ProposalSettings
) -> tuple[Searched, frozenset[int]]:
    """The search with counts as units of whole numbers, where the motion then fits clearly better; else as it was.

    Args:
        hinges: which joints turn.
        candidates: what may be positions.
        searched: the best reading without counts.
        again: searches among options of the joints.
        settings: the usual counts a turn, and how close counts as equal.

    Returns:
        The search, and the joints whose motion does not tell whether they are in counts.
    """
    whole = {
        j: candidates[each.series]
        for j, each in enumerate(searched.found.readings)
        if each.series not in searched.trial.rates and may_be_counts(candidates[each.series])
    }
    places = {j: series for j, series in whole.items() if hinges[j]}
    told = {j: size for j, series in places.items() if (size := _by_rests(series, searched.asked, settings))}
    told |= {j: size for j in whole.keys() - places.keys() if (size := _by_servo(j, searched, settings))}
    if told:
        read = enumerate(searched.found.readings)
        searched = again([Options((r.series,), (told.get(j, abs(r.factor)),), hinges[j]) for j, r in read])
    return _by_motion([j for j in places if j not in told], hinges, searched, again, settings)


def _by_motion(
    may: Sequence[int], hinges: Sequence[bool], searched: Searched, again: Again, settings: ProposalSettings
) -> tuple[Searched, frozenset[int]]:
    """As `with_counts`, of joints that may be in counts, by the equation of motion."""
    before, trial = searched.found, searched.trial
    wider = again(_opened(before.readings, may, hinges, settings)).found if may else before
    limit = most_near(wider.outcome, settings)
    if before.outcome.total > limit and float(wider.outcome.left.max()) <= settings.fits:
        as_before = {j: abs(before.readings[j].factor) for j in may}
        needed = [j for j in may if trial(_sized(wider.readings, j, as_before[j])).total > limit]
        searched = again(_opened(before.readings, needed or may, hinges, settings))
    chosen = searched.found
    limit, sizes = most_near(chosen.outcome, settings), _sizes(settings)
    undecided = (
        j
        for j in may
        if abs(chosen.readings[j].factor) == abs(before.readings[j].factor)
        and any(trial(_sized(chosen.readings, j, size)).total <= limit for size in sizes)
    )
    return searched, frozenset(undecided)


def counted_by_name(output: Output, settings: ProposalSettings) -> Output:
    """An output that is read by its name alone, with the counts that it may be in."""
    angle = output.channel.endswith(".position") and output.unit in UNITS["rad"]
    return replace(output, counts=tuple(settings.counts)) if angle and may_be_counts(output.parts[0]) else output


def doubts_of_counts(outputs: Sequence[Output]) -> Iterator[str]:
    """What is unsure of angles that may be counts, and of lengths that are, a sentence each."""
    may = [each for each in outputs if each.counts]
    if may:
        hold, are = ("holds", "is") if len(may) == 1 else ("hold", "are")
        yield (
            f"{', '.join(each.source for each in may)} {hold} whole numbers alone, as an encoder's counts are, but "
            f"{are} read in {may[0].unit}: the motion does not tell. If they are counts, take the commented lines of "
            f"the measurements: scale: {360 / may[0].counts[0]:.3g} with unit: deg is 360/{may[0].counts[0]}."
        )
    for each in outputs:
        if each.unit in UNITS["m"] and each.scale != 1.0:
            yield (
                f"{each.source} holds whole numbers alone, and is read in counts of {each.scale:g} {each.unit}, by the "
                "command that it follows. Write the encoder's own for scale: the way of one turn over its counts."
            )


def entry_of_counts(entry: Mapping[str, object], counts: Sequence[int]) -> dict[str, object]:
    """An entry of the measurements as it is if its numbers are counts, the usual ones a turn."""
    return {**entry, "unit": "deg", "scale": _scale(counts[0])}


def other_scales(counts: Sequence[int]) -> str:
    """What else to write for a scale, by counts a turn, as messages list it."""
    return ", ".join(f"{_scale(each):.5g} of {each}" for each in counts[1:])


def _scale(counts: int) -> float:
    """Degrees of one count, of so many a turn."""
    return float(f"{360 / counts:.9g}")


def _whole(value: Array) -> bool:
    return bool(np.all(value == np.round(value)))


def _sizes(settings: ProposalSettings) -> tuple[float, ...]:
    """Rad of one count."""
    return tuple(2 * math.pi / count for count in settings.counts)


def _by_rests(position: Series, commands: Sequence[Series], settings: ProposalSettings) -> float:
    """Rad of one count of a joint that comes to rest at a command whose name says its unit; 0 where none does."""
    for asked in commands:
        rest = settled(position, asked, settings) if asked.words.unit in UNITS["rad"] else None
        if rest is None:
            continue
        seen = UNITS["rad"][asked.words.unit] / abs(rest.ratio)
        size = min(_sizes(settings), key=lambda each: abs(math.log(each / seen)))
        apart = abs(math.log(size / seen)) > math.log(1 + settings.rests_off)
        if not apart and abs(rest.offset) < settings.rests_off * rest.span:
            return size
    return 0.0


def _by_servo(joint: int, searched: Searched, settings: ProposalSettings) -> float:
    """M of one count of a slide that follows a command whose name says its unit; 0 where none does, or it is none.

    A servo's slide is, on the whole, where its command is, whatever its gains are: so many counts are one of that.
    """
    outcome, reading = searched.found.outcome, searched.found.readings[joint]
    for drive in (each for each in searched.drives if each.dof == joint):
        given = outcome.given[joint][0]
        stiffness = given.stiffness or (drive.force if drive.servo else 0.0)
        asked = UNITS["m"].get(searched.asked[given.series].words.unit, 0.0)
        if stiffness and asked and explains(given, drive, outcome, settings):
            off = abs(given.gain) / (stiffness * asked)
            return 0.0 if settings.gain < off < 1 / settings.gain else float(f"{abs(reading.factor) / off:.3g}")
    return 0.0


def _opened(
    readings: Readings, joints: Sequence[int], hinges: Sequence[bool], settings: ProposalSettings
) -> list[Options]:
    """The readings as options, some of whose joints may be in counts as well."""
    return [
        Options((each.series,), (abs(each.factor), *(_sizes(settings) if j in joints else ())), hinges[j])
        for j, each in enumerate(readings)
    ]


def _sized(readings: Readings, joint: int, size: float) -> Readings:
    """The readings with another unit of a joint."""
    each = readings[joint]
    return (*readings[:joint], replace(each, factor=math.copysign(size, each.factor)), *readings[joint + 1 :])
