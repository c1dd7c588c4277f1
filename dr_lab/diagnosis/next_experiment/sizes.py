"""The largest sizes at which experiments keep their limits, found together by bisection."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from dr_lab.bounds import Count, Share, above, require_bounds
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Sizing:
    """How the largest sizes are looked for.

    Attributes:
        tries: at most.
        aim: share of the limits that the next size aims at.
        enough: share from which on a size is as good as the largest.
        shrinks: smallest factor from one size to the next, where no bracket is known.
        grows: largest factor.
    """

    tries: Count
    aim: Share
    enough: Share
    shrinks: Share
    grows: Annotated[float, above(1.0)]

    def __post_init__(self) -> None:
        require_bounds(self, "next_experiment.sizing")


class Sizes:
    """A bracket of the largest allowed factor of each of n experiments.

    Outside of a bracket the share of the limits is taken to grow as the size; inside, where that leaves it, the
    geometric mean of its ends comes next.

    Args:
        count: experiments.
        sizing: how they are looked for.

    Attributes:
        next: factors to be tried next, shape (n,).
        most: factors that are not to be passed, shape (n,).
    """

    def __init__(self, count: int, sizing: Sizing) -> None:
        self._sizing = sizing
        self.next = np.ones(count)
        self.most = np.full(count, np.inf)
        self._kept = np.zeros(count)
        self._left = np.full(count, np.inf)

    @property
    def kept(self) -> Array:
        """Largest factors that were seen to keep the limits; the smallest tried where none was, shape (n,)."""
        return np.where(self._kept > 0, self._kept, self.next)

    def seen(self, excess: Array) -> None:
        """Take in the largest share of any limit that the experiments took at the factors tried, shape (n,)."""
        able, tried, rules = excess <= 1, self.next, self._sizing
        self._kept = np.where(able, np.maximum(self._kept, tried), self._kept)
        self._left = np.where(able, self._left, np.minimum(self._left, tried))
        step = np.clip(rules.aim / np.maximum(excess, np.finfo(float).tiny), rules.shrinks, rules.grows)
        asked = tried * step
        outside = (asked <= self._kept) | (asked >= self._left)
        middle = np.sqrt(self._kept * np.where(np.isfinite(self._left), self._left, self._kept))
        asked = np.where(outside & (self._kept > 0), middle, asked)
        done = able & (excess >= rules.enough)
        self.next = np.minimum(np.where(done, self._kept, asked), self.most)
