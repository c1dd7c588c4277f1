"""Returns over a grid of contexts."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from dr_lab.bounds import Count, at_least, require_bounds
from dr_lab.evaluators.context_axes import cells, context_axes
from dr_lab.evaluators.evaluator import Evaluation, Evaluator, Progress, Subject
from dr_lab.evaluators.statistics import means_of_contexts
from dr_lab.recorders.training import ContextAxis, Grid
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class GridEvaluator(Evaluator):
    """Episodes in every cell of a grid over one or two parameters; the others keep their nominal values.

    Source: Mozifian et al. 2020, figures 1 and 9 (10 rollouts a cell).

    Attributes:
        axes: by parameter, [lowest, highest, number of values] in SI units; None takes all parameters of the model,
            which then must be one or two, within their bounds.
        count: values of a parameter where `axes` is None.
        episodes: in each cell.
        parallel: episodes side by side.
        seed: of the episodes' starts.
        solved: mean return from which on a context counts as solved; None where the task names none.

    Raises:
        ConfigError: a number is too small.
    """

    axes: Mapping[str, Sequence[float]] | None
    count: Annotated[int, at_least(2)]
    episodes: Count
    parallel: Count
    seed: int
    solved: float | None = None

    def __post_init__(self) -> None:
        require_bounds(self, "evaluator")

    def evaluate(self, subject: Subject, folder: Path, progress: Progress) -> Evaluation:
        """Play every cell.

        Raises:
            ConfigError: there are more than two parameters to vary, or none.
            UnknownNameError: an axis is no parameter of the model.
        """
        del folder
        axes = context_axes(subject.setting.space, self.axes, self.count, 2)
        z = cells(subject.setting.space, axes)
        rollouts = subject.rollouts(self.parallel, self.seed)
        repeated = np.repeat(z, self.episodes, axis=0)
        loads = [repeated[first : first + self.parallel] for first in range(0, len(repeated), self.parallel)]
        played = []
        for done, load in enumerate(loads, start=1):
            played.append(rollouts.outcomes(load))
            progress(done / len(loads))
        returns, infeasible = (np.concatenate(each).reshape(len(z), -1) for each in zip(*played, strict=True))
        found = summed_up(subject.name, axes, returns, infeasible)
        figures = {**found.figures, **self._solved(found.grids[0])}
        return replace(found, figures=figures, told=self._told(len(z)))

    def _solved(self, grid: Grid) -> dict[str, float]:
        """Share of the contexts that are solved and, over one parameter, the lowest value at which one is."""
        if self.solved is None:
            return {}
        reached = grid.mean >= self.solved  # of NaN, an infeasible context, this is false
        share = {"solved": float(reached.mean())}
        if len(grid.axes) > 1:
            return share
        (axis,) = grid.axes
        return share | {"lowest_solved": float(axis.values[reached].min()) if reached.any() else float("nan")}

    def _told(self, contexts: int) -> str:
        told = (
            f"{self.episodes} episodes in each of {contexts} contexts. An episode that diverges counts with the return "
            "that the task declares, and diverged is their share in a context. infeasible is the share of contexts in "
            "which every episode does, or which do not compile; these have no return."
        )
        if self.solved is None:
            return told
        return f"{told} solved is the share of contexts whose mean is {self.solved:g} or more."


def summed_up(title: str, axes: Sequence[ContextAxis], returns: Array, infeasible: NDArray[np.bool_]) -> Evaluation:
    """Mean and standard deviation of each cell's returns.

    Args:
        title: of the picture.
        axes: of the grid.
        returns: of every episode, shape (cells, episodes).
        infeasible: whether it ended as infeasible, shape (cells, episodes); a cell is where all did.
    """
    shape = tuple(len(axis.values) for axis in axes)
    mean, diverged = means_of_contexts(returns, infeasible), infeasible.mean(axis=1)
    spread = np.where(np.isfinite(mean), returns.std(axis=1), np.nan)
    combinations = itertools.product(*(axis.values.tolist() for axis in axes))
    rows = [
        {
            **dict(zip((axis.name for axis in axes), values, strict=True)),
            "return": float(m),
            "std": float(s),
            "diverged": float(d),
        }
        for values, m, s, d in zip(combinations, mean, spread, diverged, strict=True)
    ]
    feasible = mean[np.isfinite(mean)]
    figures = {
        "mean_return": float(feasible.mean()) if len(feasible) else float("nan"),
        "worst_return": float(feasible.min()) if len(feasible) else float("nan"),
        "best_return": float(feasible.max()) if len(feasible) else float("nan"),
        "infeasible": float(np.mean(~np.isfinite(mean))),
        "diverged": float(diverged[np.isfinite(mean)].mean()) if len(feasible) else float("nan"),
    }
    grid = Grid(title, list(axes), mean.reshape(shape), spread.reshape(shape), "episodes")
    return Evaluation(figures, rows, {axis.name: axis.unit for axis in axes}, [grid])
