"""How often contexts of each kind were drawn over training, pooled over the runs of a group."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from dr_lab.bounds import Count, at_least, require_bounds
from dr_lab.recorders.sampling import Sampled
from dr_lab.reports.plain import Number
from dr_lab.reports.train import ContextEntry, TrainReport
from dr_lab.summaries.groups import Group
from dr_lab.summaries.runs import Run, drawn_contexts
from dr_lab.summaries.uniformity import Uniformity, uniformity
from dr_lab.trajectory import Array

_FRAMES = "frames"
_REACHED = 1e-4  # probability of a bin


@dataclass(frozen=True)
class SamplingSettings:
    """How draws are counted.

    Attributes:
        block: control steps.
        bins: of a parameter's range.

    Raises:
        ConfigError: a number is out of its bounds.
    """

    block: Count
    bins: Annotated[int, at_least(2)]

    def __post_init__(self) -> None:
        require_bounds(self, "sampling")


@dataclass(frozen=True)
class Sampling:
    """Draws of a parameter by the runs of a group.

    Attributes:
        sampled: their counts, in bins that all groups share.
        low: lower end of the range between which they are judged, in bins of its own.
        high: upper end of it.
        inside: draws between them.
        uniformity: the judgement; None where there are too few.
    """

    sampled: Sampled
    low: float
    high: float
    inside: int
    uniformity: Uniformity | None


def samplings(groups: Sequence[Group], settings: SamplingSettings) -> dict[str, list[Sampling]]:
    """By parameter, what each group drew of it; nothing where that was one value throughout.

    Args:
        groups: of runs; those that were not trained, or noted no contexts, are left out.
        settings: how draws are counted.

    Raises:
        DataError: a file of contexts cannot be read.
    """
    found: dict[str, list[_Draws]] = {}
    for group in groups:
        for draws in _of_group(group):
            found.setdefault(draws.name, []).append(draws)
    return {name: _counted(each, settings) for name, each in found.items()}


@dataclass(frozen=True)
class _Draws:
    """What the runs of a group drew of a parameter, each after how many control steps of `trained`, and their range."""

    group: str
    name: str
    unit: str
    trained: int
    frames: Sequence[Array]
    value: Sequence[Array]
    low: float
    high: float

    @property
    def every(self) -> Array:
        return np.concatenate(self.value)


def _of_group(group: Group) -> Iterator[_Draws]:
    runs = [(run.content, columns) for run in group.runs if (columns := _columns(run))]
    reports = [report for report, _ in runs if isinstance(report, TrainReport)]
    for name in runs[0][1] if runs else ():
        noted = [columns for _, columns in runs if name in columns]
        if name == _FRAMES or not all(name in report.context for report in reports):
            continue
        frames, value = [each[_FRAMES] for each in noted], [each[name] for each in noted]
        if np.ptp(np.concatenate(value)):
            entry = reports[0].context[name]
            trained, span = max(report.frames for report in reports), _range(entry, np.concatenate(value))
            yield _Draws(group.label, name, entry.unit, trained, frames, value, *span)


def _columns(run: Run) -> Mapping[str, Array]:
    columns = drawn_contexts(run)
    return columns if len(columns.get(_FRAMES, ())) else {}


def _range(entry: ContextEntry, drawn: Array) -> tuple[float, float]:
    """Where the distribution reached that training began with.

    Its histogram tells that to a bin, which is exact at the parameter's bounds; elsewhere the draws tell more. A bin
    counts where one draw in the first ten thousand falls: an exact normal density is nowhere zero.
    """
    known = entry.histogram
    if known is None:
        return float(drawn.min()), float(drawn.max())
    likely = np.flatnonzero(np.array(known.initial) > _REACHED)
    low, high = _noted(known.edges[likely[0]]), _noted(known.edges[likely[-1] + 1])
    inside = drawn[(drawn >= low) & (drawn <= high)]
    if not len(inside):
        return low, high
    return low if _at(low, entry.low) else float(inside.min()), high if _at(high, entry.high) else float(inside.max())


def _noted(end: float) -> float:
    """An end as a context there is noted, in single precision, which may lie beyond the end itself."""
    return float(np.float32(end))


def _at(value: float, bound: Number) -> bool:
    return bound is not None and bool(np.isclose(value, bound))


def _counted(draws: Sequence[_Draws], settings: SamplingSettings) -> list[Sampling]:
    low = min(min(each.low, float(each.every.min())) for each in draws)
    high = max(max(each.high, float(each.every.max())) for each in draws)
    edges = np.linspace(low, high, settings.bins + 1)
    return [_sampling(each, _ends(each.trained, settings.block), edges) for each in draws]


def _ends(trained: int, block: int) -> NDArray[np.integer]:
    """Of the blocks of a training; what is left of it, less than half a block, is part of the last one."""
    ends = block * np.arange(max(1, round(trained / block)) + 1)
    ends[-1] = trained
    return ends


def _sampling(draws: _Draws, ends: NDArray[np.integer], edges: Array) -> Sampling:
    inside, judged = 0, None
    if draws.high > draws.low:
        own = _counts(draws, ends, np.linspace(draws.low, draws.high, len(edges)))
        inside, judged = int(own.sum()), uniformity(own)
    count = _counts(draws, ends, edges).sum(axis=0)
    sampled = Sampled(draws.group, draws.name, draws.unit, len(draws.value), ends, edges, count)
    return Sampling(sampled, draws.low, draws.high, inside, judged)


def _counts(draws: _Draws, ends: NDArray[np.integer], edges: Array) -> NDArray[np.integer]:
    """By run, block and bin."""
    pairs = zip(draws.frames, draws.value, strict=True)
    return np.array([np.histogram2d(frames, value, [ends, edges])[0] for frames, value in pairs]).astype(np.int64)
