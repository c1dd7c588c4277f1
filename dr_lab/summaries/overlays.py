"""What the groups of a sweep show together: curves with intervals, learned distributions, returns over contexts."""

import functools
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from dr_lab.errors import DataError
from dr_lab.evaluators.statistics import iqm_band
from dr_lab.recorders.training import Band, ContextAxis, Grid, Marginal, Sample
from dr_lab.reports.evaluate import Cell, EvaluateReport
from dr_lab.reports.train import ContextEntry, TrainReport
from dr_lab.summaries.groups import Group, Statistics
from dr_lab.summaries.runs import Run, history
from dr_lab.trajectory import Array

_COUNTS = ("iteration", "frames", "rollout_frames", "seconds", "episodes")
_FIRST = "episode_return"
_GRID = "GridEvaluator"
_DOMAINS = "UnseenDomainsEvaluator"
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
        contexts = [run.content.context for run in group.runs if isinstance(run.content, TrainReport)]
        for name, first in contexts[0].items() if contexts else ():
            entries = [context[name] for context in contexts if name in context and context[name].histogram]
            if any(entry.std for entry in entries):
                found.setdefault(name, {})[group.label] = _mean_marginal(name, first, entries)
    return found


def grids(groups: Sequence[Group]) -> dict[str, Grid]:
    """By group, returns over contexts: mean and standard deviation over the episodes of all its runs, cell by cell.

    Raises:
        DataError: runs of a group were evaluated over different contexts, or a row lacks a column.
    """
    found: dict[str, Grid] = {}
    for group in groups:
        each = {run.folder: run.content for run in group.runs if isinstance(run.content, EvaluateReport)}
        drawn = {folder: report for folder, report in each.items() if report.evaluator == _GRID and report.rows}
        if drawn:
            found[group.label] = _mean_grid(group.label, drawn)
    return found


def violins(groups: Sequence[Group]) -> dict[str, list[Sample]]:
    """By group, returns in unseen domains, and in those that were trained on, over all its runs."""
    found: dict[str, list[Sample]] = {}
    for group in groups:
        each = [run.content for run in group.runs if isinstance(run.content, EvaluateReport)]
        rows = [row for report in each if report.evaluator == _DOMAINS for row in report.rows]
        kinds = dict.fromkeys(str(row["domains"]) for row in rows)
        returns = {kind: np.array([_number(row["return"]) for row in rows if row["domains"] == kind]) for kind in kinds}
        if returns:
            found[group.label] = [Sample(f"{group.label} · {kind}", values) for kind, values in returns.items()]
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


def _mean_marginal(name: str, first: ContextEntry, entries: Sequence[ContextEntry]) -> Marginal:
    """Over the edges of all: where a distribution reaches, and with it its bins, differs from run to run."""
    each = [entry.histogram for entry in entries if entry.histogram is not None]
    edges = functools.reduce(np.union1d, [np.array(entry.edges) for entry in each])
    learned = np.mean([_rebinned(entry.probability, entry.edges, edges) for entry in each], axis=0)
    initial = _rebinned(each[0].initial, each[0].edges, edges)
    bounds = _number(first.low), _number(first.high)
    part = bounds if bounds[0] < edges[0] and edges[-1] < bounds[1] else None
    return Marginal(name, first.unit, edges, initial, np.zeros(1, int), learned[None], part)


def _rebinned(probability: Sequence[float], edges: Sequence[float], finer: Array) -> Array:
    """Probabilities of finer bins, of a density that is constant in each bin and 0 beyond them."""
    return np.diff(np.interp(finer, edges, np.concatenate([[0.0], np.cumsum(probability)])))


def _mean_grid(title: str, reports: Mapping[Path, EvaluateReport]) -> Grid:
    """Over the reports of grids, by their run folders."""
    (folder, first), *_ = reports.items()
    names = [name for name in first.rows[0] if name not in _OF_A_CELL]
    contexts = [[row.get(name) for name in names] for row in first.rows]
    for other, report in reports.items():
        if [[row.get(name) for name in names] for row in report.rows] != contexts:
            raise DataError(
                f"{other} was evaluated over other contexts than {folder}, with which it would be averaged. "
                "Take one of them out, or aggregate over fewer keys: aggregate=…"
            )
    axes = [ContextAxis(name, first.units.get(name, ""), np.unique(_column(folder, first, name))) for name in names]
    shape = tuple(len(axis.values) for axis in axes)
    mean, std = (np.array([_column(*each, name) for each in reports.items()]) for name in _CELL)
    # Over the episodes of all runs together, as many of each.
    spread = np.sqrt(np.mean(std**2, axis=0) + np.var(mean, axis=0))
    return Grid(title, axes, np.mean(mean, axis=0).reshape(shape), spread.reshape(shape), "episodes of all runs")


def _column(folder: Path, report: EvaluateReport, name: str) -> Array:
    """A column of a report's table, NaN where it is empty."""
    if any(name not in row for row in report.rows):
        raise DataError(f"{folder / 'report.json'}: a row lacks {name!r}, which those of evaluator=grid have.")
    return np.array([_number(row[name]) for row in report.rows])


def _number(cell: Cell) -> float:
    return np.nan if cell is None else float(cell)
