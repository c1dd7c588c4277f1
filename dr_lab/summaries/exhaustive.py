"""The exhaustive grid: a policy of its own for every context."""

from collections.abc import Mapping, Sequence

import numpy as np

from dr_lab.recorders.training import ContextAxis, Grid
from dr_lab.reports.train import TrainReport
from dr_lab.summaries.groups import ABSENT, Group
from dr_lab.summaries.runs import Run

LABEL = "a policy for each context"
_VALUES = "randomizer.values"  # where the only context of a run stands


def exhaustive(groups: Sequence[Group]) -> dict[str, Grid]:
    """Final returns of policies that were trained at one context each, over these contexts.

    Drawn where the runs' contexts differ in one or two parameters. A cell is the mean of a group's runs, its spread
    their standard deviation; a cell in which nothing was trained is NaN. What else tells groups apart makes further
    grids.

    Source: Mozifian et al. 2020, figure 1a.

    Args:
        groups: of runs; those that were not trained, or at more than one context, are left out.

    Returns:
        By label.
    """
    found: dict[str, list[Group]] = {}
    for group in groups:
        if all(_at_one_context(run) for run in group.runs):
            others = [f"{key}={value}" for key, value in group.settings.items() if _tells_apart(key, value)]
            found.setdefault(", ".join([LABEL, *others]), []).append(group)
    drawn = {label: _grid(label, alike) for label, alike in found.items()}
    return {label: grid for label, grid in drawn.items() if grid is not None}


def _grid(label: str, groups: Sequence[Group]) -> Grid | None:
    reports = [_trained(group) for group in groups]
    contexts = [_context(of_group[0]) for of_group in reports]
    values = {name: np.unique([context[name] for context in contexts]) for name in contexts[0]}
    varied = {name: each for name, each in values.items() if len(each) > 1}
    if not 1 <= len(varied) <= 2:
        return None
    units = reports[0][0].context
    axes = [ContextAxis(name, units[name].unit, each) for name, each in varied.items()]
    mean, spread = np.full((2, *(len(axis.values) for axis in axes)), np.nan)
    for of_group, context in zip(reports, contexts, strict=True):
        cell = tuple(int(np.searchsorted(axis.values, context[axis.name])) for axis in axes)
        returns = [value for value in map(_return, of_group) if value is not None]
        if returns:
            mean[cell], spread[cell] = np.mean(returns), np.std(returns)
    return Grid(label, axes, mean, spread, "runs")


def _return(report: TrainReport) -> float | None:
    """Of the deployed policy, where it is known."""
    return report.final_return if report.deployed_return is None else report.deployed_return


def _trained(group: Group) -> list[TrainReport]:
    """The reports of a group's runs that were trained."""
    return [run.content for run in group.runs if isinstance(run.content, TrainReport)]


def _context(report: TrainReport) -> Mapping[str, float]:
    """The only context that a policy was trained at, value by parameter; empty where there were more."""
    alone = {name: entry.mean for name, entry in report.context.items() if entry.mean is not None and entry.std == 0.0}
    return alone if len(alone) == len(report.context) else {}


def _at_one_context(run: Run) -> bool:
    return isinstance(run.content, TrainReport) and bool(_context(run.content))


def _tells_apart(key: str, value: str) -> bool:
    return not key.startswith(_VALUES) and value != ABSENT
