"""How fast the cost of a fit falls, by its last steps."""

from collections import deque


class Pace:
    """The gains of the last steps.

    Args:
        count: number of steps that tell a pace; of fewer nothing is said.
    """

    def __init__(self, count: int) -> None:
        self._gains = deque[float](maxlen=count)

    def add(self, gain: float) -> None:
        """Take note of a step; one that would raise the cost is not made and gains nothing."""
        self._gains.append(max(gain, 0.0))

    def crawls(self, least: float) -> bool:
        """Whether the last steps together gained less than so much."""
        return self._known and sum(self._gains) < least

    def too_slow(self, distance: float, steps: int) -> bool:
        """Whether the cost would not fall by a distance in so many steps more."""
        return self._known and sum(self._gains) / len(self._gains) * steps < distance

    @property
    def _known(self) -> bool:
        return len(self._gains) == self._gains.maxlen
