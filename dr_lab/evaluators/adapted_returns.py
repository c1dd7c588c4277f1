"""Returns of adapted policies over a grid of contexts, summed up."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dr_lab.evaluators.evaluator import Evaluation
from dr_lab.evaluators.statistics import t_intervals
from dr_lab.recorders.training import ContextAxis, Gain, Grid
from dr_lab.reports.quantity import counted
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class AdaptedReturns:
    """What came of adapting in every cell of a grid.

    Attributes:
        axes: of the grid.
        returns: of every adaptation after each number of updates, shape (cells, repeats, updates + 1); NaN where the
            context is infeasible.
        inside: cells within the bounds of the context, shape (cells,).
        confidence: of the intervals.
    """

    axes: Sequence[ContextAxis]
    returns: Array
    inside: NDArray[np.bool_]
    confidence: float

    def summed_up(self) -> Evaluation:
        """Figures, a row a cell and number of updates, and maps of returns and gains."""
        mean, *_ = t_intervals(self._last(self.returns), self.confidence)
        gain = t_intervals(self._last(self.returns[..., 1:] - self.returns[..., :1]), self.confidence)
        rows = [row for cell in range(len(mean)) for row in self._rows(cell, mean, gain)]
        units = {axis.name: axis.unit for axis in self.axes}
        grids = [self._grid(k, mean[:, k]) for k in range(mean.shape[1])]
        gains = [self._gain(k, *(each[:, k] for each in gain)) for k in range(mean.shape[1] - 1)]
        return Evaluation(self._figures(mean, gain), rows, units, [*grids, _over_updates(mean)], gains=gains)

    def _last(self, values: Array) -> Array:
        """With the repeats as the last dimension."""
        return np.moveaxis(values, 1, -1)

    def _rows(self, cell: int, mean: Array, gain: tuple[Array, ...]) -> list[dict[str, float]]:
        """A row for each number of updates."""
        at = np.unravel_index(cell, self._shape)
        context = {axis.name: float(axis.values[index]) for axis, index in zip(self.axes, at, strict=True)}
        none = 0.0 if np.isfinite(mean[cell, 0]) else np.nan
        own = [[none, *each[cell].tolist()] for each in gain]
        return [
            {**context, "updates": float(k), "return": float(value), "gain": each, "low": low, "high": high}
            for k, (value, each, low, high) in enumerate(zip(mean[cell], *own, strict=True))
        ]

    def _figures(self, mean: Array, gain: tuple[Array, ...]) -> dict[str, float]:
        value, low, high = gain
        found = {f"return_after_{k}": _mean(each) for k, each in enumerate(mean.T)}
        found |= {f"gain_{k}": _mean(each) for k, each in enumerate(value.T, start=1)}
        known = np.isfinite(value).all(axis=1)
        for name, sure in (("hurts", high < 0.0), ("helps", low > 0.0)):
            found |= {f"{name}_{k}": _mean(each[known]) for k, each in enumerate(sure.T.astype(float), start=1)}
        found["correlation"] = _correlation(mean[known, 1], value[known, 0])
        if self.inside.any() and not self.inside.all():
            for name, of in (("inside", self.inside), ("outside", ~self.inside)):
                found[f"return_after_1_{name}"], found[f"gain_1_{name}"] = _mean(mean[of, 1]), _mean(value[of, 0])
        return {**found, "infeasible": float(np.mean(~np.isfinite(mean[:, 0])))}

    def _grid(self, updates: int, mean: Array) -> Grid:
        known = np.isfinite(mean)
        spread = np.full(len(mean), np.nan)
        spread[known] = np.nanstd(self.returns[known, :, updates], axis=1)
        return Grid(_after(updates), self.axes, mean.reshape(self._shape), spread.reshape(self._shape), "adaptations")

    def _gain(self, index: int, value: Array, low: Array, high: Array) -> Gain:
        shaped = (each.reshape(self._shape) for each in (value, low, high))
        return Gain(f"of {counted(index + 1, 'update')}", self.axes, *shaped)

    @property
    def _shape(self) -> tuple[int, ...]:
        return tuple(len(axis.values) for axis in self.axes)


def _over_updates(mean: Array) -> Grid:
    """Mean over the contexts after each number of updates, and their spread."""
    known = mean[np.isfinite(mean).all(axis=1)]
    axis = ContextAxis("updates", "", np.arange(mean.shape[1], dtype=float))
    if not len(known):
        known = np.full((1, mean.shape[1]), np.nan)
    return Grid("over updates", [axis], known.mean(axis=0), known.std(axis=0), "contexts")


def _after(updates: int) -> str:
    return f"after {counted(updates, 'update')}" if updates else "before the first update"


def _mean(values: Array) -> float:
    """Mean of what is known, NaN where nothing is."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else float("nan")


def _correlation(one: Array, other: Array) -> float:
    """Pearson's; NaN where it is not defined."""
    if len(one) < 2 or not one.std() > 0.0 or not other.std() > 0.0:
        return float("nan")
    return float(np.corrcoef(one, other)[0, 1])
