"""The exhaustive grid: a policy of its own for every context."""

from collections.abc import Mapping, Sequence

import numpy as np

from dr_lab.recorders.training import ContextAxis, Grid
from dr_lab.summaries.groups import ABSENT, Group, is_known
from dr_lab.summaries.runs import TRAIN_SCHEMA, Run

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
        if all(_context(run) for run in group.runs):
            others = [f"{key}={value}" for key, value in group.settings.items() if _tells_apart(key, value)]
            found.setdefault(", ".join([LABEL, *others]), []).append(group)
    drawn = {label: _grid(label, alike) for label, alike in found.items()}
    return {label: grid for label, grid in drawn.items() if grid is not None}


def _grid(label: str, groups: Sequence[Group]) -> Grid | None:
    contexts = [_context(group.runs[0]) for group in groups]
    values = {name: np.unique([context[name] for context in contexts]) for name in contexts[0]}
    varied = {name: each for name, each in values.items() if len(each) > 1}
    if not 1 <= len(varied) <= 2:
        return None
    units = groups[0].runs[0].report["context"]
    axes = [ContextAxis(name, units[name]["unit"], each) for name, each in varied.items()]
    mean, spread = np.full((2, *(len(axis.values) for axis in axes)), np.nan)
    for group, context in zip(groups, contexts, strict=True):
        cell = tuple(int(np.searchsorted(axis.values, context[axis.name])) for axis in axes)
        returns = [run.report["final_return"] for run in group.runs if is_known(run.report.get("final_return"))]
        if returns:
            mean[cell], spread[cell] = np.mean(returns), np.std(returns)
    return Grid(label, axes, mean, spread)


def _context(run: Run) -> Mapping[str, float]:
    """The only context that a run was trained at, value by parameter; empty where there were more."""
    context = run.report.get("context") or {}
    if run.report["schema"] != TRAIN_SCHEMA or any(entry.get("std") != 0.0 for entry in context.values()):
        return {}
    return {name: float(entry["mean"]) for name, entry in context.items()}


def _tells_apart(key: str, value: str) -> bool:
    return not key.startswith(_VALUES) and value != ABSENT
