"""The learned distribution over time, and what it was learnt by, as recordings show it."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from dr_lab.randomizers.gaussian import GaussianRandomizer
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.recorders.training import Comparison, Comparisons, Marginal, Pair, Spread
from dr_lab.training.narrow_bins import narrow_bins, rebinned, seen, shared_bins
from dr_lab.trajectory import Array


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
        axes = range(len(self._randomizer.space.names))
        marginals = [self._randomizer.marginal(axis) for axis in axes]
        narrow = {axis: list(bins) for axis in axes if (bins := narrow_bins(self._randomizer, axis)) is not None}
        moments = self._randomizer.moments()
        mean, covariance = (None, None) if moments is None else moments
        self._taken.append({"iteration": iteration, "marginals": marginals, "mean": mean, "covariance": covariance})
        self._taken[-1] |= {"narrow": narrow} if narrow else {}
        self._taken[-1] |= (
            {"compared": [asdict(each) for each in compared]} if compared else {}
        )  # as checkpoints take it

    def marginals(self) -> list[Marginal]:
        """One parameter each, over its bounds and as far beyond as p_φ(z) reaches, at most once their width.

        Where p_φ(z) is always much narrower than the bounds, over where it lies.
        """
        return [self._marginal(axis) for axis in range(len(self._randomizer.space.names))]

    def _marginal(self, axis: int) -> Marginal:
        parameter, wide = self._randomizer.space.parameters[axis], self._randomizer.edges(axis)
        bounds = (parameter.low, parameter.high)
        probability = np.array([each["marginals"][axis] for each in self._taken])
        first, last = _shown(probability, *np.searchsorted(wide, bounds).tolist())
        narrow = [each.get("narrow", {}).get(axis) for each in self._taken]
        own = [None if bins is None else bins[0] for bins in narrow]
        edges, part = shared_bins(own, wide[first : last + 1], parameter.high - parameter.low)
        shares = [each if bins is None else bins[1] for each, bins in zip(probability, narrow, strict=True)]
        known = zip(shares, (wide if each is None else each for each in own), strict=True)
        shown = np.array([rebinned(share, between, edges) for share, between in known])
        among = bounds if part else None
        return Marginal(parameter.name, parameter.unit, edges, shown[0], self._iterations, shown, among)

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


def _shown(probability: Array, low: int, high: int) -> tuple[int, int]:
    """First bin that a picture shows and the first that it does not, of probabilities (k, b).

    Args:
        probability: of each bin at k times.
        low: first bin within the bounds, which are always shown.
        high: first bin above them.
    """
    first, last = seen(probability)
    return min(first, low), max(last, high)
