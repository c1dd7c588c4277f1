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

_BINS = 60  # of a histogram where p(z) has none of its own
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
        """One parameter each; the prior is what was kept first."""
        parameters = self._randomizer.space.parameters
        found = []
        for axis, parameter in enumerate(parameters):
            probability = np.array([each["marginals"][axis] for each in self._taken])
            edges = np.linspace(parameter.low, parameter.high, probability.shape[1] + 1)
            found.append(Marginal(parameter.name, parameter.unit, edges, probability[0], self._iterations, probability))
        return found

    def pairs(self) -> list[Pair]:
        """Every two parameters."""
        space = self._randomizer.space
        mean = np.array([each["mean"] for each in self._taken])
        covariance = np.array([each["covariance"] for each in self._taken])
        return [
            Pair(
                (space.names[i], space.names[j]),
                (space.parameters[i].unit, space.parameters[j].unit),
                space.low[[i, j]],
                space.high[[i, j]],
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
        """Probabilities of equal bins over the bounds; exact where p_φ is a grid over just these."""
        space = self._randomizer.space
        low, high = space.low[axis], space.high[axis]
        grid = self._randomizer.distribution()
        if isinstance(grid, Histogram) and grid.low[axis] == low and grid.high[axis] == high:
            others = [k for k in range(grid.logits.ndim) if k != axis]
            probabilities = grid.log_probabilities.detach().exp()
            return (torch.sum(probabilities, others) if others else probabilities).numpy()
        return np.histogram(draws, bins=_BINS, range=(low, high))[0] / len(draws)
