"""Runs that differ in nothing but the seed, taken together."""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import yaml

from dr_lab.bounds import Confidence, Count, Natural, require_bounds
from dr_lab.errors import UnknownNameError
from dr_lab.evaluators.statistics import Interval, improvement_interval, iqm_interval
from dr_lab.summaries.configuration import experiment, holds
from dr_lab.summaries.runs import Figure, Run, picked, units
from dr_lab.sweeps.overrides import differing
from dr_lab.sweeps.sweep import identity_of


@dataclass(frozen=True)
class Estimate(Interval):
    """A mean with its interval.

    Attributes:
        runs: that it is of; those without the figure do not count.
        larger: probability that it is larger in one of these runs than in one of the reference; None of the reference.
    """

    runs: int
    larger: Interval | None = None


Cell = Estimate | Mapping[str, int]
Cells = Mapping[str, Cell]
"""Figures of several runs by path: a mean with its interval, or how often each word came up."""

ABSENT = ""  # in place of an override that was not given
_DIGITS = 8  # of an identity that are shown
CONFIGURATION = "configuration"  # setting that tells apart runs with the same overrides


@dataclass(frozen=True)
class Statistics:
    """How figures of several runs are summed up: interquartile mean and percentile bootstrap.

    Attributes:
        confidence: of the interval, below 1.
        resamples: of the bootstrap.
        seed: of the bootstrap.

    Raises:
        ConfigError: a number is out of its bounds.
    """

    confidence: Confidence
    resamples: Count
    seed: Natural

    def __post_init__(self) -> None:
        require_bounds(self, "statistics")


@dataclass(frozen=True)
class Group:
    """Runs with the same settings.

    Attributes:
        settings: the overrides that differ between groups, value by key.
        runs: they.
        label: what tells it from the others, in short.
    """

    settings: Mapping[str, str]
    runs: Sequence[Run]
    label: str


def grouped(runs: Sequence[Run], aggregate: Sequence[str], ignored: Sequence[str] = ()) -> list[Group]:
    """Runs by what differs between them apart from `aggregate`, groups in the order of their first runs.

    Runs with the same overrides that were configured differently, e.g. because a file changed between them, are told
    apart by the setting `CONFIGURATION`.

    Args:
        runs: to be grouped.
        aggregate: overrides over which runs are taken together.
        ignored: further keys of configurations that do not tell runs apart.
    """
    typed = differing([run.overrides for run in runs])
    keys = [key for key in typed if key not in aggregate]
    # What an option of `_global_`, such as an experiment, brought into a configuration cannot be taken out again.
    unknown = [key for key in typed if key in aggregate and not any(holds(run.configuration, key) for run in runs)]
    found: dict[tuple[str, ...], dict[str, list[Run]]] = {}
    for run in runs:
        identity = "" if unknown else identity_of(experiment(run.configuration, [*ignored, *aggregate]))
        alike = found.setdefault(tuple(run.overrides.get(key, ABSENT) for key in keys), {})
        alike.setdefault(identity, []).append(run)
    members = [together for alike in found.values() for together in alike.values()]
    settings = [
        dict(zip(keys, values, strict=True)) | ({} if len(members) == len(found) else _configuration(identity, alike))
        for values, alike in found.items()
        for identity in alike
    ]
    return [Group(*group) for group in zip(settings, members, _labels(settings), strict=True)]


def figures_of(run: Run, figures: Mapping[str, Sequence[str]]) -> dict[str, Figure]:
    """What of a run's report is compared.

    Args:
        run: the run.
        figures: paths into a report, by its schema.
    """
    return picked(run.report, figures.get(str(run.report.get("schema")), ()))


def units_of(groups: Sequence[Group], figures: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """Units of figures that have one in the runs' reports, by path; arguments as `summed_up`."""
    each = [run.report for group in groups for run in group.runs]
    return {k: unit for report in each for k, unit in units(report, figures.get(str(report["schema"]), ())).items()}


def shared_figures(groups: Sequence[Group], figures: Mapping[str, Sequence[str]]) -> dict[str, Figure]:
    """Figures that are known of every run of several groups, and the same.

    Args:
        groups: of runs; of one alone no figure counts as shared, for there is nothing that it could differ between.
        figures: paths into a report, by its schema.
    """
    if len(groups) == 1:
        return {}
    first, *others = [figures_of(run, figures) for group in groups for run in group.runs]
    return {
        name: value
        for name, value in first.items()
        if is_known(value) and all(other.get(name) == value for other in others)
    }


def summed_up(
    group: Group, figures: Mapping[str, Sequence[str]], statistics: Statistics, reference: Group | None = None
) -> Cells:
    """Interquartile mean with its interval of every number, and how often every word came up, by path.

    Args:
        group: of runs.
        figures: paths into a report, by its schema.
        statistics: how figures are summed up.
        reference: the group that this one is compared with, if it is another.
    """
    settings = (statistics.confidence, statistics.resamples, statistics.seed)
    theirs = {} if reference is None or reference is group else _known(reference, figures)
    found: dict[str, Cell] = {}
    for name, values in _known(group, figures).items():
        if any(isinstance(value, str) for value in values):
            found[name] = Counter(str(value) for value in values)
            continue
        numbers, others = (
            np.array([v for v in each if not isinstance(v, str)]) for each in (values, theirs.get(name, []))
        )
        interval = iqm_interval(numbers, *settings)
        larger = improvement_interval(numbers, others, *settings) if len(numbers) and len(others) else None
        found[name] = Estimate(interval.value, interval.low, interval.high, len(numbers), larger)
    return found


def find_group(groups: Sequence[Group], label: str | None) -> Group:
    """The group of a label, the first one where none is given.

    Raises:
        UnknownNameError: there is none.
    """
    if label is None:
        return groups[0]
    labels = {group.label: group for group in groups}
    if label not in labels:
        raise UnknownNameError("group", label, labels, "these runs (reference)")
    return labels[label]


def _known(group: Group, figures: Mapping[str, Sequence[str]]) -> dict[str, list[Figure]]:
    """What is known of each figure that a run of a group reports."""
    each = [figures_of(run, figures) for run in group.runs]
    names = dict.fromkeys(name for row in each for name in row)
    return {name: [row[name] for row in each if is_known(row.get(name))] for name in names}


def known_in(cell: Cell) -> int:
    """How many runs a figure is of."""
    return cell.runs if isinstance(cell, Estimate) else sum(cell.values())


def is_known(figure: Figure | None) -> bool:
    """Whether a run has a figure: it has none where the report says null, or infinity."""
    return isinstance(figure, str) or (figure is not None and math.isfinite(figure))


def _configuration(identity: str, alike: Mapping[str, Sequence[Run]]) -> dict[str, str]:
    return {CONFIGURATION: f"#{identity[:_DIGITS]}" if len(alike) > 1 else ABSENT}


def _labels(settings: Sequence[Mapping[str, str]]) -> list[str]:
    """What tells groups apart: in short, but with whole keys where these or the labels would be alike."""
    times = Counter(map(_last, settings[0]))
    names = {key: _last(key) if times[_last(key)] == 1 else key for key in settings[0]}

    def told(key: str, value: str) -> str:
        # The option of a group says enough by itself; true, false and null say nothing.
        word = value.isidentifier() and isinstance(yaml.safe_load(value), str)
        return value if word and "." not in key else f"{names[key]}={value}"

    short = [_label(each, told) for each in settings]
    whole = [_label(each, "{}={}".format) for each in settings]
    alike = Counter(short)
    return [one if alike[one] == 1 else other for one, other in zip(short, whole, strict=True)]


def _label(settings: Mapping[str, str], told: Callable[[str, str], str]) -> str:
    given = ", ".join(told(key, value) for key, value in settings.items() if value != ABSENT)
    return given or ("as configured" if settings else "all runs")


def _last(key: str) -> str:
    return key.rpartition(".")[2]
