"""Sampling frequency over training as a report tells it."""

import math
from collections.abc import Mapping, Sequence

from dr_lab.reports.page import Section
from dr_lab.reports.plain import Number
from dr_lab.reports.quantity import ABSENT, number, titled
from dr_lab.reports.summarize import SamplingEntry
from dr_lab.reports.tables import table
from dr_lab.summaries.sampling import Sampling, SamplingSettings
from dr_lab.summaries.uniformity import LEAST

KEY = "sampling"
_SMALLEST = 0.0001  # probability that is told
_TOLD = (
    "How often contexts were drawn for training, counted over all runs of a setting in blocks of about {} control "
    "steps; a shorter training is one block. A proposal of a learner counts once.\n\n"
    "χ²/dof compares the counts in {} bins of the range that training began with to those of a uniform distribution, "
    "block by block. It is about 1 where draws are uniform and independent, as in uniform domain randomisation; p is "
    "the probability of a larger one there. Proposals of a walk depend on one another, which raises χ² by itself: p "
    "between runs allows for that, by counting only what the runs prefer alike. A small one is not yet something "
    "learnt: walks without any preference visit the ends of a range less often."
)
_FEW = f"– in place of χ²: no block holds {LEAST} draws a bin, on average. "
_POINT = "– in place of χ² where a setting began with one value: there is no range in which draws could be uniform."


def sampling_section(found: Mapping[str, Sequence[Sampling]], settings: SamplingSettings) -> Section:
    """The table, a row a parameter and group; empty where nothing was drawn."""
    every = [each for of_parameter in found.values() for each in of_parameter]
    if not every:
        return Section(KEY, "", "")
    header = ["parameter", "setting", "runs", "draws", "range", "χ²/dof", "p", "p between runs"]
    parts = [_TOLD.format(settings.block, settings.bins), table(header, [_row(each) for each in every])]
    if any(each.low == each.high for each in every):
        parts.append(_POINT)
    few = [each for each in every if each.uniformity is None and each.low < each.high]
    if few:
        parts.append(_FEW + _remedy(min(few, key=lambda each: each.inside), settings))
    return Section(KEY, "Sampling frequency", "\n\n".join(parts))


def sampling_entries(found: Mapping[str, Sequence[Sampling]]) -> tuple[SamplingEntry, ...]:
    """The counts as `report.json` holds them."""
    return tuple(_entry(each) for of_parameter in found.values() for each in of_parameter)


def _remedy(found: Sampling, settings: SamplingSettings) -> str:
    """What would do, or almost, for the fewest draws; so many blocks as hold enough on average have one that does."""
    trained, blocks = int(found.sampled.frames[-1]), found.inside // (LEAST * settings.bins)
    if blocks:
        return f"Take longer blocks: sampling.block={math.ceil(trained / blocks)}."
    bins = found.inside // LEAST
    if bins > 1:
        return f"Take fewer bins and all of the training in a block: sampling.bins={bins} sampling.block={trained}."
    return f"Of {found.sampled.name} {found.sampled.group} drew {found.inside} values in the range; train longer."


def _row(found: Sampling) -> list[str]:
    sampled, judged = found.sampled, found.uniformity
    told = [ABSENT] * 3
    if judged is not None:
        told = [number(judged.chi2 / judged.dof, 3), _probability(judged.p), _probability(judged.p_between)]
    span = f"{number(found.low)} … {number(found.high)}"
    drawn = str(int(sampled.count.sum()))
    return [titled(sampled.name, sampled.unit), sampled.group, str(sampled.runs), drawn, span, *told]


def _probability(p: Number) -> str:
    """To two digits; of very small ones these say nothing."""
    return f"< {_SMALLEST}" if p is not None and p < _SMALLEST else number(p, 2)


def _entry(found: Sampling) -> SamplingEntry:
    sampled, judged = found.sampled, found.uniformity
    return SamplingEntry(
        group=sampled.group,
        parameter=sampled.name,
        unit=sampled.unit,
        runs=sampled.runs,
        frames=tuple(sampled.frames.tolist()),
        edges=tuple(sampled.edges.tolist()),
        count=tuple(tuple(row) for row in sampled.count.tolist()),
        low=found.low,
        high=found.high,
        chi2=None if judged is None else judged.chi2,
        dof=0 if judged is None else judged.dof,
        p=None if judged is None else judged.p,
        p_between=None if judged is None else judged.p_between,
    )
