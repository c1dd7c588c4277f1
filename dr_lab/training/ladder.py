"""The iterations of a learner that compares the model with a target, one after the other."""

from collections.abc import Mapping, Sequence

import numpy as np

from dr_lab.recorders.training import Decline, Spread
from dr_lab.reports.train import MomentsEntry, RungEntry
from dr_lab.training.history import History


def ladder(history: History, spreads: Sequence[Spread]) -> tuple[RungEntry, ...]:
    """The beginning, then a rung for each iteration; empty where nothing was compared.

    Args:
        history: of the run; rows of such an iteration hold a discrepancy.
        spreads: mean and standard deviation of each parameter, taken at the beginning and after every row.
    """
    rows = [row for row in history if "discrepancy" in row]
    if not rows:
        return ()
    return (_rung({"iteration": 0.0, "frames": 0.0}, spreads), *(_rung(row, spreads) for row in rows))


def declines(rungs: Sequence[RungEntry]) -> list[Decline]:
    """How the discrepancy falls; nothing where none is known."""
    iteration = np.array([rung.iteration for rung in rungs[1:]])
    values = {
        "draws, before": _column([rung.discrepancy for rung in rungs[1:]]),
        "mean, after": _column([rung.discrepancy_of_mean for rung in rungs[1:]]),
    }
    known = any(np.nan_to_num(column).max(initial=0.0) > 0.0 for column in values.values())
    return [Decline("discrepancy", iteration, values)] if known else []


def _rung(row: Mapping[str, float], spreads: Sequence[Spread]) -> RungEntry:
    context = {}
    for spread in spreads:
        at = int(np.searchsorted(spread.iteration, row["iteration"]))
        context[spread.name] = MomentsEntry(spread.unit, float(spread.mean[at]), float(spread.std[at]))
    return RungEntry(
        iteration=int(row["iteration"]),
        frames=int(row["frames"]),
        discrepancy=row.get("discrepancy"),
        discrepancy_of_mean=row.get("discrepancy_of_mean"),
        divergence=row.get("divergence"),
        target_steps=int(row.get("target_steps", 0)),
        context=context,
    )


def _column(values: Sequence[float | None]) -> np.ndarray:
    return np.array([np.nan if value is None else value for value in values])
