"""What the groups of a sweep show together: curves with intervals, learned distributions, returns over contexts."""

import functools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from dr_lab.errors import DataError
from dr_lab.evaluators.statistics import iqm_band
from dr_lab.recorders.training import Band, ContextAxis, Grid, Marginal
from dr_lab.summaries.groups import Group, Statistics
from dr_lab.summaries.runs import TRAIN_SCHEMA, Run, history
from dr_lab.trajectory import Array

_COUNTS = ("iteration", "frames", "rollout_frames", "seconds", "episodes")
_HISTOGRAM = {"edges", "initial", "probability"}  # what a run keeps of a distribution that it knows
_FIRST = "episode_return"
_CELL = ("return", "std")
_OF_A_CELL = (*_CELL, "diverged")  # columns that are no axis


def bands(groups: Sequence[Group], statistics: Statistics) -> list[Band]:
    """Every figure of training over control steps, the return first; runs of a group count where all of them are.

    Args:
        groups: of runs; those that were not trained are left out.
        statistics: how runs are summed up.
    """
    found = [band for group in groups for band in _of_group(group, statistics)]
    return sorted(found, key=lambda band: (band.name != _FIRST, band.name))


def marginals(groups: Sequence[Group]) -> dict[str, dict[str, Marginal]]:
    """By parameter and group, what was learnt in the end, averaged over runs; nothing where it is one value."""
    found: dict[str, dict[str, Marginal]] = {}
    for group in groups:
        contexts = [run.report.get("context") or {} for run in group.runs if run.report["schema"] == TRAIN_SCHEMA]
        for name in contexts[0] if contexts else ():
            entries = [context[name] for context in contexts if set(context.get(name, {})) >= _HISTOGRAM]
            if any(entry["std"] for entry in entries):
                found.setdefault(name, {})[group.label] = _mean_marginal(name, entries)
    return found


def grids(groups: Sequence[Group]) -> dict[str, Grid]:
    """By group, returns over contexts, averaged over its runs cell by cell.

    Raises:
        DataError: runs of a group were evaluated over different contexts.
    """
    found: dict[str, Grid] = {}
    for group in groups:
        runs = [run for run in group.runs if run.report.get("evaluator") == "GridEvaluator" and run.report.get("rows")]
        if runs:
            found[group.label] = _mean_grid(group.label, runs)
    return found


def _of_group(group: Group, statistics: Statistics) -> Iterator[Band]:
    tables = [columns for columns in map(_by_frames, group.runs) if columns]
    if not tables:
        return
    shared = functools.reduce(np.intersect1d, [np.array(list(table)) for table in tables])
    names = [name for name in next(iter(tables[0].values())) if name not in _COUNTS]
    for name in names:
        values = np.array([[table[frames].get(name, np.nan) for frames in shared.tolist()] for table in tables])
        if np.isfinite(values).any():
            settings = (statistics.confidence, statistics.resamples, statistics.seed)
            yield Band(group.label, name, shared.astype(int), *iqm_band(values, *settings))


def _by_frames(run: Run) -> dict[float, dict[str, float]]:
    """Rows of a run's history by the control steps they stand at."""
    columns = history(run)
    if "frames" not in columns:
        return {}
    rows = zip(*columns.values(), strict=True)
    return {row["frames"]: row for row in (dict(zip(columns, map(float, values), strict=True)) for values in rows)}


def _mean_marginal(name: str, entries: Sequence[Mapping[str, Any]]) -> Marginal:
    """Over the edges of all: where a distribution reaches, and with it its bins, differs from run to run."""
    edges = functools.reduce(np.union1d, [entry["edges"] for entry in entries])
    learned = np.mean([_rebinned(entry["probability"], entry["edges"], edges) for entry in entries], axis=0)
    initial = _rebinned(entries[0]["initial"], entries[0]["edges"], edges)
    return Marginal(name, entries[0]["unit"], edges, initial, np.zeros(1, int), learned[None])


def _rebinned(probability: Sequence[float], edges: Sequence[float], finer: Array) -> Array:
    """Probabilities of finer bins, of a density that is constant in each bin and 0 beyond them."""
    return np.diff(np.interp(finer, edges, np.concatenate([[0.0], np.cumsum(probability)])))


def _mean_grid(title: str, runs: Sequence[Run]) -> Grid:
    tables = [run.report["rows"] for run in runs]
    names = [name for name in tables[0][0] if name not in _OF_A_CELL]
    for run, rows in zip(runs, tables, strict=True):
        if [[row.get(name) for name in names] for row in rows] != [[row[name] for name in names] for row in tables[0]]:
            raise DataError(
                f"{run.folder} was evaluated over other contexts than {runs[0].folder}, with which it would be "
                "averaged. Take one of them out, or aggregate over fewer keys: aggregate=…"
            )
    units = runs[0].report.get("units", {})
    axes = [ContextAxis(name, units.get(name, ""), np.unique([row[name] for row in tables[0]])) for name in names]
    shape = tuple(len(axis.values) for axis in axes)
    mean, spread = (np.array([_column(table, key) for table in tables]).mean(axis=0).reshape(shape) for key in _CELL)
    return Grid(title, axes, mean, spread)


def _column(table: Sequence[Mapping[str, Any]], name: str) -> Array:
    return np.array([np.nan if row[name] is None else row[name] for row in table])
