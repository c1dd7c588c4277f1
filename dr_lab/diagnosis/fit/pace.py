"""How fast the cost of a fit falls, by its last steps."""

from collections import deque

from dr_lab.diagnosis.settings import SolverSettings


class Pace:
    """The gains of the last steps.

    Args:
        settings: how many steps tell a pace, and that a descent crawls; of fewer nothing is said.
        cost: before the first one.

    Attributes:
        costs: before the first step, and the lowest after each.
    """

    def __init__(self, settings: SolverSettings, cost: float) -> None:
        self._settings, self.costs = settings, [cost]
        self._gains = deque[float](maxlen=max(settings.crawl, settings.pace))

    def add(self, cost: float, after: float) -> None:
        """Take note of a step from one cost to another; one that would raise it is not made, and its gain negative."""
        self._gains.append(cost - after)
        self.costs.append(min(cost, after))

    def crawls(self, least: float) -> bool:
        """Whether the last steps together gained less than so much, and moved the cost up and down by little more.

        Steps that would raise it by much meet a bend, behind which shorter ones may gain.
        """
        last, swing = self._last(self._settings.crawl), self._settings.crawl_swing
        return bool(last) and _gained(last) < least and sum(map(abs, last)) < swing * least

    def too_slow(self, distance: float, steps: int) -> bool:
        """Whether the cost would not fall by a distance in so many steps more."""
        last = self._last(self._settings.pace)
        return bool(last) and _gained(last) / len(last) * steps < distance

    def _last(self, count: int) -> list[float]:
        """The gains of so many steps; none where there were fewer."""
        return list(self._gains)[-count:] if len(self._gains) >= count else []


def _gained(gains: list[float]) -> float:
    return sum(max(gain, 0.0) for gain in gains)
