"""The decrease of a fit's cost that tells nothing."""

from dr_lab.diagnosis.fit.autocorrelation import colour
from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.settings import SolverSettings


class Tolerance:
    """How far from its optimum a fit may end.

    A share of the cost is so much evidence, Δχ² of as many independent residuals as there are. Of coloured residuals
    there are fewer, so that a larger share of the cost is as little evidence.

    Args:
        replay: what is fitted.
        settings: the shares.
        rough: whether the fit only decides which candidates are fitted again.
    """

    def __init__(self, replay: Replay, settings: SolverSettings, *, rough: bool) -> None:
        self._replay, self._rough = replay, rough
        self._share, self._most = settings.tolerance, settings.rough_tolerance
        self._noise = float(replay.fitted.sum())  # the cost that noise alone leaves

    def least(self, point: Point) -> float:
        """Decrease of the cost that tells nothing; of the rough tolerance at most."""
        share = self._most if self._rough else min(self._share * self._colour(point), self._most)
        return share * max(point.cost, self._noise)

    def _colour(self, point: Point) -> float:
        rows = (self._replay.by_channel(each) for each in (point.residuals, self._replay.fitted.astype(float)))
        return colour((residual, used > 0) for (_, residual), (_, used) in zip(*rows, strict=True))
