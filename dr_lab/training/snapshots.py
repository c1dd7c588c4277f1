"""The learned distribution over time, and what it was learnt by, as recordings show it."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from dr_lab.randomizers.gaussian import GaussianRandomizer
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.recorders.training import Comparison, Comparisons, Marginal, Pair, Spread
from dr_lab.trajectory import Array

_UNSEEN = 1e-3  # share of draws beyond either end of a picture


class Snapshots:
    """Keeps marginals, mean and covariance of p_φ(z) from iteration to iteration, and what a learner compared.

    Args:
        randomizer: p_φ(z), as it is whenever `take` is called.
    """

    def __init__(self, randomizer: Randomizer) -> None:
        self._randomizer = randomizer
        self._taken: list[dict[str, Any]] = []

    def take(self, iteration: int, compared: Sequence[Comparison] = ()) -> None:
        """Keep p_φ(z) as it is now, and what this iteration compared."""
        marginals = [self._randomizer.marginal(axis) for axis in range(len(self._randomizer.space.names))]
        moments = self._randomizer.moments()
        mean, covariance = (None, None) if moments is None else moments
        self._taken.append({"iteration": iteration, "marginals": marginals, "mean": mean, "covariance": covariance})
        self._taken[-1] |= (
            {"compared": [asdict(each) for each in compared]} if compared else {}
        )  # as checkpoints take it

    def marginals(self) -> list[Marginal]:
        """One parameter each, over its bounds and as far beyond as p_φ(z) reaches, at most once their width."""
        found, space = [], self._randomizer.space
        for axis, parameter in enumerate(space.parameters):
            probability, edges = (
                np.array([each["marginals"][axis] for each in self._taken]),
                self._randomizer.edges(axis),
            )
            first, last = _seen(probability, *np.searchsorted(edges, [space.low[axis], space.high[axis]]).tolist())
            edges, shown = edges[first : last + 1], probability[:, first:last]
            found.append(Marginal(parameter.name, parameter.unit, edges, shown[0], self._iterations, shown))
        return found

    def spreads(self) -> list[Spread]:
        """One parameter each, of a Gaussian, whose bands these are."""
        if not isinstance(self._randomizer, GaussianRandomizer):
            return []
        mean = np.array([each["mean"] for each in self._taken])
        std = np.sqrt(np.array([np.diag(each["covariance"]) for each in self._taken]))
        return [
            Spread(p.name, p.unit, self._iterations, mean[:, i], std[:, i])
            for i, p in enumerate(self._randomizer.space.parameters)
        ]

    def comparisons(self) -> list[Comparisons]:
        """One quantity each; none where nothing was compared."""
        known = [each for each in self._taken if "compared" in each]
        iteration = np.array([each["iteration"] for each in known])
        by_quantity = zip(*(each["compared"] for each in known), strict=True)
        return [Comparisons(iteration, [Comparison(**each) for each in shown]) for shown in by_quantity]

    def pairs(self) -> list[Pair]:
        """Every two parameters; none where the randomizer tells no moments."""
        space, ends = self._randomizer.space, np.array([each.edges[[0, -1]] for each in self.marginals()])
        if any(each["mean"] is None for each in self._taken):
            return []
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


def _seen(probability: Array, low: int, high: int) -> tuple[int, int]:
    """First bin that a picture shows and the first that it does not, of probabilities (k, b).

    Args:
        probability: of each bin at k times.
        low: first bin within the bounds, which are always shown.
        high: first bin above them.
    """
    cumulated = probability.cumsum(1)
    first = int((cumulated < _UNSEEN).sum(1).min())
    last = int((cumulated < cumulated[:, -1:] - _UNSEEN).sum(1).max()) + 1
    return min(first, low), max(last, high)
