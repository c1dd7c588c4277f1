"""What is to be seen of a training run: figures as it goes on, the learned distribution, returns over contexts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from dr_lab.reports.quantity import number, titled
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Curve:
    """One figure as training goes on.

    Attributes:
        name: what it is, e.g. ``return``.
        unit: of its values; empty where it has none.
        at: iterations or control steps, shape (k,), increasing.
        value: shape (k,); NaN where it is unknown.
        over: which of the two `at` counts, ``frames`` being control steps.
    """

    name: str
    unit: str
    at: NDArray[np.integer]
    value: Array
    over: Literal["iteration", "frames"] = "iteration"


@dataclass(frozen=True)
class Marginal:
    """The distribution of one context parameter over iterations, as a histogram.

    Attributes:
        name: the parameter.
        unit: its unit.
        edges: of the bins, shape (b + 1,).
        initial: probability of each bin under the distribution that training began with, shape (b,).
        iteration: shape (k,), increasing.
        probability: probability of each bin, shape (k, b).
        bounds: of the parameter, where the bins show only a part of what lies between them.
    """

    name: str
    unit: str
    edges: Array
    initial: Array
    iteration: NDArray[np.integer]
    probability: Array
    bounds: tuple[float, float] | None = None

    @property
    def title(self) -> str:
        """Of the parameter's axis."""
        part = "" if self.bounds is None else f", part of its bounds {' to '.join(map(number, self.bounds))}"
        return titled(self.name, self.unit) + part

    @property
    def learned(self) -> bool:
        """Whether it changed while training went on."""
        return len(self.iteration) > 1


@dataclass(frozen=True)
class Spread:
    """Mean and standard deviation of one context parameter over iterations.

    Attributes:
        name: the parameter.
        unit: its unit.
        iteration: shape (k,), increasing.
        mean: shape (k,).
        std: shape (k,).
    """

    name: str
    unit: str
    iteration: NDArray[np.integer]
    mean: Array
    std: Array


@dataclass(frozen=True)
class Comparison:
    """One quantity of one episode, as a target moved and as the model moves.

    Attributes:
        name: of the quantity, e.g. ``arm.position``.
        unit: its unit.
        time: after the episode's start, s, shape (t,).
        target: shape (t,).
        mean: of the model at the mean of the distribution, shape (t,).
        drawn: of the model in a few contexts that were drawn from it, shape (m, t).
    """

    name: str
    unit: str
    time: Array
    target: Array
    mean: Array
    drawn: Array


@dataclass(frozen=True)
class Comparisons:
    """What was compared of one quantity over iterations.

    Attributes:
        iteration: shape (k,), increasing.
        shown: k comparisons, of the same quantity.
    """

    iteration: NDArray[np.integer]
    shown: Sequence[Comparison]


@dataclass(frozen=True)
class Decline:
    """Figures above 0 that fall by orders of magnitude.

    Attributes:
        name: what they are, with their unit.
        iteration: shape (k,), increasing.
        values: by what the legend calls them, shape (k,) each; NaN where it is unknown.
    """

    name: str
    iteration: NDArray[np.integer]
    values: Mapping[str, Array]


@dataclass(frozen=True)
class Pair:
    """Mean and covariance of two context parameters over iterations.

    Attributes:
        names: the parameters.
        units: theirs.
        low: lowest values that are shown, shape (2,).
        high: highest, shape (2,).
        iteration: shape (k,), increasing.
        mean: shape (k, 2).
        covariance: shape (k, 2, 2).
    """

    names: tuple[str, str]
    units: tuple[str, str]
    low: Array
    high: Array
    iteration: NDArray[np.integer]
    mean: Array
    covariance: Array


@dataclass(frozen=True)
class Band:
    """One figure of several like runs over control steps.

    Attributes:
        group: what the runs have in common.
        name: of the figure.
        frames: control steps, shape (k,), increasing.
        value: their interquartile mean, shape (k,); NaN where it is unknown.
        low: lower end of its interval, likewise.
        high: upper end, likewise.
    """

    group: str
    name: str
    frames: NDArray[np.integer]
    value: Array
    low: Array
    high: Array


@dataclass(frozen=True)
class ContextAxis:
    """One parameter of a grid of contexts.

    Attributes:
        name: the parameter.
        unit: its unit.
        values: its values in the grid, increasing, shape (n,).
    """

    name: str
    unit: str
    values: Array


@dataclass(frozen=True)
class Grid:
    """Returns over a grid of contexts in one or two parameters.

    Attributes:
        title: whose returns they are, e.g. the run or the policy.
        axes: one or two.
        mean: mean return of each cell, shape (n,) or (n, m); NaN where the context is infeasible.
        spread: standard deviation of what is in a cell, likewise.
        over: what that is over, in words, e.g. ``episodes``.
    """

    title: str
    axes: Sequence[ContextAxis]
    mean: Array
    spread: Array
    over: str


def over_what(grids: Sequence[Grid]) -> str:
    """What the spreads of some grids are over, one grid at least; with the grids' titles where it differs."""
    different = dict.fromkeys(grid.over for grid in grids)
    if len(different) == 1:
        return grids[0].over
    titles = {over: ", ".join(grid.title for grid in grids if grid.over == over) for over in different}
    return ", ".join(f"{over} ({whose})" for over, whose in titles.items())


@dataclass(frozen=True)
class Matrix:
    """Cosines of the angles between the policy gradients of every two contexts along one parameter.

    Attributes:
        title: of which policy, and how they were estimated.
        axis: the contexts.
        value: shape (n, n); NaN where it is unknown.
        doubtful: whether its sign is, shape (n, n).
    """

    title: str
    axis: ContextAxis
    value: Array
    doubtful: NDArray[np.bool_]


@dataclass(frozen=True)
class Gain:
    """What updates add to the return over a grid of contexts in one or two parameters.

    Attributes:
        title: of how many updates.
        axes: one or two.
        value: mean of each cell, shape (n,) or (n, m); NaN where it is unknown.
        low: lower end of its interval, likewise.
        high: upper end, likewise; where both are of one sign the gain has that sign, else it is in doubt.
    """

    title: str
    axes: Sequence[ContextAxis]
    value: Array
    low: Array
    high: Array

    @property
    def doubtful(self) -> NDArray[np.bool_]:
        """Where the sign is in doubt, of the shape of `value`."""
        return ~((self.low > 0.0) | (self.high < 0.0))


@dataclass(frozen=True)
class Ways:
    """Ways of a policy in the plane, before and after it was adapted to where it is to go.

    Attributes:
        title: after how many updates.
        goals: m, shape (k, 2).
        before: k courses of x and y, m, shape (t, 2) each.
        after: likewise.
    """

    title: str
    goals: Array
    before: Sequence[Array]
    after: Sequence[Array]


@dataclass(frozen=True)
class Sample:
    """Returns whose scatter is looked at.

    Attributes:
        name: what tells them from others beside them.
        value: shape (k,); NaN where it is unknown, e.g. of an infeasible context.
        told: a sentence on what each value is.
    """

    name: str
    value: Array
    told: str = ""
