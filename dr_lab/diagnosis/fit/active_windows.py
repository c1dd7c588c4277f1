"""The windows whose states are still looked for, and perhaps some that are done: those that are simulated."""

from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.slopes import quick_differences
from dr_lab.diagnosis.settings import SolverSettings
from dr_lab.trajectory import Array

_NO_PARAMETER = np.zeros(0, np.intp)
_WORTH = 0.5  # share of the simulated windows below which those still active get simulations of their own
_AT_ONCE = 4  # steps; of those of starts behind friction half fail, and each failure raises the damping once
_FEW = 16  # simulations; where laws act, so many of a pendulum take at most twice as long as one


class ActiveWindows:
    """Some of a replay's windows.

    Args:
        replay: of these windows.
        rows: their places among all windows.
        settings: sizes of the differences.
    """

    def __init__(self, replay: Replay, rows: NDArray[np.intp], settings: SolverSettings) -> None:
        self.replay = replay
        self.rows = rows
        self.settings = settings

    @cached_property
    def at_once(self) -> int:
        """How many steps of each window are tried at once.

        Where laws act from step to step, few simulations take about as long as one. Else each takes its own time.
        """
        return min(_AT_ONCE, max(_FEW // len(self.rows), 1)) if self.replay.model.lawful else 1

    def narrowed(self, active: NDArray[np.bool_]) -> "ActiveWindows":
        """The active windows alone, once they are so few that new simulations of them pay."""
        kept = active[self.rows]
        if kept.sum() > _WORTH * len(kept) or not kept.any():
            return self
        return ActiveWindows(self.replay.part(np.flatnonzero(kept)), self.rows[kept], self.settings)

    def tried(self, point: Point, steps: Array) -> list[Point]:
        """The point after each of k steps (k, w, s), where the windows are among these; elsewhere as it is."""
        delta = point.delta[self.rows] + steps[:, self.rows]
        residuals, lost = self.replay.residuals(np.tile(point.z, (len(steps), 1)), delta)
        return [self._after(point, *each) for each in zip(delta, residuals, lost, strict=True)]

    def _after(self, point: Point, delta: Array, residuals: Array, lost: NDArray[np.bool_]) -> Point:
        whole = point.delta.copy(), point.residuals.copy(), point.infeasible.copy()
        for every, own in zip(whole, (delta, residuals, lost), strict=True):
            every[self.rows] = own
        return Point(point.z, whole[0], whole[1], np.inf, whole[2])

    def renew(self, point: Point, slopes: Array) -> Array:
        """The slopes ∂r/∂δ at the point in these windows; elsewhere as they are, shape (w, m, s)."""
        here = replace(
            point,
            delta=point.delta[self.rows],
            residuals=point.residuals[self.rows],
            infeasible=point.infeasible[self.rows],
        )
        slopes = slopes.copy()
        slopes[self.rows] = quick_differences(self.replay, self.settings, here, states=True, columns=_NO_PARAMETER)
        return slopes
