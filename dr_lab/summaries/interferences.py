"""Cosines between the policy gradients of contexts, over the runs of a group."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from dr_lab.errors import DataError
from dr_lab.evaluators.statistics import t_intervals
from dr_lab.recorders.interference import Interference
from dr_lab.recorders.training import ContextAxis
from dr_lab.reports.evaluate import Cell, EvaluateReport
from dr_lab.summaries.groups import Group
from dr_lab.trajectory import Array

_EVALUATOR = "GradientInterferenceEvaluator"
_FRAMES, _COSINE, _SIGN, _SIDES = "frames", "cosine", "sign", (" a", " b")
_Row = Mapping[str, Cell]


def interferences(groups: Sequence[Group], confidence: float) -> list[Interference]:
    """By group and policy, from the first that was kept to the last: the mean cosines of its runs and their spread.

    The last policy of one run goes with the last of another, that before with that before; where a run has more of them
    than another, its first ones are left out. The sign of a mean is in doubt where its interval by Student's t over the
    runs holds 0; of one run, where its evaluation says so.

    Source: Mehta 2020 (thesis), figures 3.3 to 3.7.

    Args:
        groups: of runs; those that were not evaluated by ``evaluator=gradient_interference`` are left out.
        confidence: of the intervals, below 1.

    Raises:
        DataError: runs of a group were evaluated over different contexts, or a row lacks a column.
    """
    found: list[Interference] = []
    for group in groups:
        each = {run.folder: run.content for run in group.runs if isinstance(run.content, EvaluateReport)}
        read = {folder: _Gradients(folder, report) for folder, report in each.items() if report.evaluator == _EVALUATOR}
        if read:
            found += _of_group(group.label, read, confidence)
    return found


class _Gradients:
    """An evaluation: the contexts, and by policy what was found.

    Attributes:
        axis: the contexts.
        frames: of each policy, increasing.
        cosine: of each policy, shape (n, n).
        sign: likewise.
    """

    def __init__(self, folder: Path, report: EvaluateReport) -> None:
        try:
            name = next(key.removesuffix(_SIDES[0]) for key in report.units if key.endswith(_SIDES[0]))
            first, second = (f"{name}{side}" for side in _SIDES)
            values = np.unique([_number(row[second]) for row in report.rows])
            self.axis = ContextAxis(name, report.units[first], values)
            by_policy: dict[float, list[_Row]] = {}
            for row in report.rows:
                by_policy.setdefault(_number(row[_FRAMES]), []).append(row)
            self.frames = sorted(by_policy)
            policies = [by_policy[frames] for frames in self.frames]
            self.cosine, self.sign = (
                [_square(rows, values, (first, second, kind)) for rows in policies] for kind in (_COSINE, _SIGN)
            )
        except (KeyError, StopIteration) as error:
            raise DataError(
                f"{folder / 'report.json'}: a row lacks {str(error) or 'its contexts'}, which "
                "evaluator=gradient_interference writes. Evaluate the policy again."
            ) from None


def _of_group(label: str, read: Mapping[Path, _Gradients], confidence: float) -> list[Interference]:
    (folder, first), *_ = read.items()
    for other, gradients in read.items():
        if gradients.axis.name != first.axis.name or not np.array_equal(gradients.axis.values, first.axis.values):
            raise DataError(
                f"{other} was evaluated over other contexts than {folder}, with which it would be averaged. "
                "Take one of them out, or aggregate over fewer keys: aggregate=…"
            )
    every, fewest = list(read.values()), min(len(gradients.frames) for gradients in read.values())
    return [
        _mean(label, first.axis, [(g.frames[k], g.cosine[k], g.sign[k]) for g in every], confidence)
        for k in range(-fewest, 0)
    ]


def _mean(
    label: str, axis: ContextAxis, policies: Sequence[tuple[float, Array, Array]], confidence: float
) -> Interference:
    frames, cosine = np.mean([frames for frames, *_ in policies]), np.stack([each for _, each, _ in policies], axis=-1)
    mean, low, high = t_intervals(cosine, confidence)
    alone = len(policies) == 1
    spread = np.full_like(mean, np.nan) if alone else _spread(cosine)
    doubtful = policies[0][2] == 0 if alone else ~((low > 0.0) | (high < 0.0))
    return Interference(label, len(policies), round(float(frames)), axis, mean, spread, doubtful)


def _spread(cosine: Array) -> Array:
    """Standard deviation over the runs that know a cell; NaN where fewer than two do."""
    known = np.isfinite(cosine)
    enough = known.sum(axis=-1) > 1
    return np.where(enough, np.nanstd(np.where(enough[..., None], cosine, 0.0), axis=-1, ddof=1), np.nan)


def _square(rows: Sequence[_Row], values: Array, columns: tuple[str, str, str]) -> Array:
    """A symmetric table of one half of its cells, shape (n, n); NaN where it is empty."""
    first, second, kind = columns
    found = np.full((len(values), len(values)), np.nan)
    for row in rows:
        a, b = (int(np.searchsorted(values, _number(row[side]))) for side in (first, second))
        found[a, b] = found[b, a] = _number(row[kind])
    return found


def _number(cell: Cell) -> float:
    return np.nan if cell is None else float(cell)
