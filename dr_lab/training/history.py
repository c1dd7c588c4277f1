"""What the figures of a training run's iterations say together."""

from collections.abc import Mapping, Sequence

import numpy as np

from dr_lab.recorders.training import Curve
from dr_lab.reports.csv_rows import rows_csv

History = Sequence[Mapping[str, float]]
"""Figures of every iteration by name."""

_NOT_PLOTTED = ("iteration", "frames", "rollout_frames", "seconds", "episodes")
_RETURN = "episode_return"
_INFEASIBLE = "infeasible_episodes"
_ADAPTED = "return_after_"  # … so many updates


def final_return(history: History, share: float) -> float | None:
    """Mean return of the feasible episodes that ended in the last iterations; None where none did.

    Args:
        history: of the run.
        share: of the iterations, the last ones, one at least.
    """
    known = _feasible(history, share)
    return sum(count * value for count, value in known) / sum(count for count, _ in known) if known else None


def final_episodes(history: History, share: float) -> int:
    """How many episodes the final return is the mean of; arguments as there."""
    return int(sum(count for count, _ in _feasible(history, share)))


def _feasible(history: History, share: float) -> list[tuple[float, float]]:
    """Number and mean return of the feasible episodes of the last iterations, those in which one ended."""
    rows = [(row["episodes"] - _infeasible(row), row[_RETURN]) for row in _last(history, share)]
    return [(count, value) for count, value in rows if count]


def adapted_returns(history: History, share: float) -> tuple[float, ...]:
    """Mean return in the tasks of the last iterations after 0, 1, … updates; empty where no policy is adapted.

    Args:
        history: of the run.
        share: of the iterations, the last ones, one at least.
    """
    rows = _last(history, share)
    columns = [[row[name] for row in rows if not np.isnan(row.get(name, np.nan))] for name in _adapted(rows)]
    return tuple(float(np.mean(known)) for known in columns if known)


def infeasible_episodes(history: History) -> int:
    """How many episodes an infeasible context ended."""
    return int(sum(map(_infeasible, history)))


def ended_episodes(history: History) -> int:
    """How many episodes ended, those in infeasible contexts included."""
    return int(sum(row.get("episodes", 0.0) for row in history))


def metrics_csv(history: History) -> str:
    """One row an iteration; what an iteration does not know is empty."""
    return rows_csv(
        [{name: "" if np.isnan(value) else f"{value:.10g}" for name, value in row.items()} for row in history]
    )


def curves(history: History) -> list[Curve]:
    """Every figure over the iterations that know it, but for those that only count or that none knows.

    Infeasible episodes are plotted where there are any. The return comes first. A figure of a learner's rounds, which
    take many iterations, is a line from round to round. Where a policy is adapted, its return is that after the last
    update, and the mean of all episodes, which mixes those before and after an update, is left out.
    """
    known = {name for row in history for name, value in row.items() if not np.isnan(value)}
    adapted = _adapted(history)
    others = [name for name in dict.fromkeys(name for row in history for name in row) if name != _RETURN]
    names = dict.fromkeys([*(adapted[-1:] or [_RETURN]), *others])
    hidden = {*_NOT_PLOTTED, *(() if infeasible_episodes(history) else (_INFEASIBLE,))}
    names = [name for name in names if name in known - hidden]
    return [_curve(name, history) for name in names]


def _adapted(history: History) -> list[str]:
    """Names of the returns after 0, 1, … updates that these iterations hold."""
    names = {name for row in history for name in row if name.startswith(_ADAPTED)}
    return sorted(names, key=lambda name: int(name.removeprefix(_ADAPTED)))


def _last(history: History, share: float) -> History:
    return history[-max(1, round(share * len(history))) :]


def _curve(name: str, history: History) -> Curve:
    known = [row for row in history if not np.isnan(row.get(name, np.nan))]
    iteration = np.array([int(row["iteration"]) for row in known], np.int64)
    return Curve(name, "", iteration, np.array([row[name] for row in known], np.float64))


def _infeasible(row: Mapping[str, float]) -> float:
    """Number of infeasible episodes; a checkpoint of an earlier version counts them among the others."""
    return row.get(_INFEASIBLE, 0.0)
