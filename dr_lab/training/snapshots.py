"""The learned distribution over time, as recordings show it."""

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np
import torch

from dr_lab.randomizers.histogram import Histogram
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.recorders.training import Marginal, Pair
from dr_lab.seeding import stream
from dr_lab.trajectory import Array

_BINS = 60  # of a histogram over the bounds where p(z) has none of its own; as many are kept on either side of them
_UNSEEN = 1e-3  # share of draws beyond either end of a picture
_DRAWS = 4000  # from the same stream each time, so that a picture moves only where the distribution does


class Snapshots:
    """Keeps marginals, mean and covariance of p_φ(z) from iteration to iteration.

    Args:
        randomizer: p_φ(z), as it is whenever `take` is called.
    """

    def __init__(self, randomizer: Randomizer) -> None:
        self._randomizer = randomizer
        self._taken: list[dict[str, Any]] = []

    def take(self, iteration: int) -> None:
        """Keep p_φ(z) as it is now."""
        z = self._randomizer.sample([stream(0, "snapshot")] * _DRAWS)
        marginals = [self._marginal(axis, z[:, axis]) for axis in range(z.shape[1])]
        mean, covariance = z.mean(0), np.atleast_2d(np.cov(z.T))
        self._taken.append({"iteration": iteration, "marginals": marginals, "mean": mean, "covariance": covariance})

    def marginals(self) -> list[Marginal]:
        """One parameter each, over its bounds and as far beyond as p_φ(z) reaches, at most once their width."""
        found = []
        for axis, parameter in enumerate(self._randomizer.space.parameters):
            probability = np.array([each["marginals"][axis] for each in self._taken])
            first, last = (0, probability.shape[1]) if self._grid(axis) is not None else _seen(probability)
            edges, shown = self._edges(axis)[first : last + 1], probability[:, first:last]
            found.append(Marginal(parameter.name, parameter.unit, edges, shown[0], self._iterations, shown))
        return found

    def pairs(self) -> list[Pair]:
        """Every two parameters."""
        space, ends = self._randomizer.space, np.array([each.edges[[0, -1]] for each in self.marginals()])
        mean = np.array([each["mean"] for each in self._taken])
        covariance = np.array([each["covariance"] for each in self._taken])
        return [
            Pair(
                (space.names[i], space.names[j]),
                (space.parameters[i].unit, space.parameters[j].unit),
                ends[[i, j], 0],
                ends[[i, j], 1],
                self._iterations,
                mean[:, [i, j]],
                covariance[:, [[i], [j]], [[i, j]]],
            )
            for i, j in itertools.combinations(range(len(space.names)), 2)
        ]

    def state_dict(self) -> dict[str, Any]:
        """All that was kept."""
        return {"taken": list(self._taken)}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self._taken = list(state["taken"])

    @property
    def _iterations(self) -> np.ndarray:
        return np.array([each["iteration"] for each in self._taken])

    def _marginal(self, axis: int, draws: Array) -> Array:
        """Probabilities of the bins; exact where p_φ is a grid over just the bounds."""
        grid = self._grid(axis)
        if grid is not None:
            others = [k for k in range(grid.logits.ndim) if k != axis]
            probabilities = grid.log_probabilities.detach().exp()
            return (torch.sum(probabilities, others) if others else probabilities).numpy()
        high = self._randomizer.space.high[axis]
        inside = np.where(draws == high, np.nextafter(high, -np.inf), draws)  # bins are open above
        edges = self._edges(axis)
        return np.histogram(np.clip(inside, edges[0], edges[-1]), edges)[0] / len(draws)  # what is beyond: in the last

    def _edges(self, axis: int) -> Array:
        """Edges of the bins, shape (b + 1,): over the bounds and, where p_φ is no grid over them, beside them."""
        space, grid = self._randomizer.space, self._grid(axis)
        low, high = space.low[axis], space.high[axis]
        if grid is not None:
            return np.linspace(low, high, grid.logits.shape[axis] + 1)
        below, above = 2 * low - high, 2 * high - low
        parts = [np.linspace(*ends, _BINS, endpoint=False) for ends in ((below, low), (low, high), (high, above))]
        return np.concatenate([*parts, [above]])

    def _grid(self, axis: int) -> Histogram | None:
        space, found = self._randomizer.space, self._randomizer.distribution()
        if not isinstance(found, Histogram):
            return None
        return found if (found.low[axis], found.high[axis]) == (space.low[axis], space.high[axis]) else None


def _seen(probability: Array) -> tuple[int, int]:
    """First bin that a picture shows and the first that it does not, of probabilities (k, b) over bounds and beside."""
    cumulated = probability.cumsum(1)
    first = int((cumulated < _UNSEEN).sum(1).min())
    last = int((cumulated < cumulated[:, -1:] - _UNSEEN).sum(1).max()) + 1
    return min(first, _BINS), max(last, 2 * _BINS)
