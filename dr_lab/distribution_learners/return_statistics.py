"""Standardised returns, so that a regulariser's weight does not depend on a task's rewards."""

from collections.abc import Mapping

import numpy as np

from dr_lab.trajectory import Array

_EPSILON = 1e-8  # keeps equal returns at 0


class ReturnStatistics:
    """Exponentially averaged batch statistics of returns (Mozifian et al. 2020, §IV-A).

    R̂ = (R − m)/(s + ε), m and s the averages m ← m + λ(mean R − m) and s ← s + λ(std R − s), each divided by
    1 − (1 − λ)ᵗ: after t batches that makes them averages of what was seen, whatever they started from. (The code
    released with the paper starts from m = 0, s = 1 without that division, so its R̂ is large for some 1/λ iterations.)

    An infeasible context counts as the worst feasible one seen so far; before there is any, a batch says nothing.

    Args:
        rate: λ in (0, 1], share of the newest batch.
    """

    def __init__(self, rate: float) -> None:
        self.rate = rate
        self.mean = 0.0
        self.std = 0.0
        self.weight = 0.0
        self.lowest = np.inf

    def standardise(self, returns: Array) -> Array:
        """Take a batch (k,) into account and return it standardised; NaN stands for infeasible."""
        feasible = returns[~np.isnan(returns)]
        self.lowest = min(self.lowest, *feasible, np.inf)
        if not np.isfinite(self.lowest):
            return np.zeros_like(returns)
        filled = np.where(np.isnan(returns), self.lowest, returns)
        self.mean += self.rate * (float(filled.mean()) - self.mean)
        self.std += self.rate * (float(filled.std()) - self.std)
        self.weight += self.rate * (1.0 - self.weight)
        return (filled - self.mean / self.weight) / (self.std / self.weight + _EPSILON)

    def state_dict(self) -> dict[str, float]:
        """The averages."""
        return {"mean": self.mean, "std": self.std, "weight": self.weight, "lowest": self.lowest}

    def load_state_dict(self, state: Mapping[str, float]) -> None:
        """Continue from what `state_dict` gave."""
        self.mean, self.std, self.weight = state["mean"], state["std"], state["weight"]
        self.lowest = state["lowest"]
