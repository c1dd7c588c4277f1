"""Slopes that follow a descent, taken anew only where its steps ask for it."""

from enum import IntEnum

import numpy as np

from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.slopes import Slopes, quick_differences
from dr_lab.diagnosis.settings import SolverSettings


class Fresh(IntEnum):
    """Which slopes were taken where a descent is."""

    NONE = 0
    MOST = 1  # by the parameters, but those of free bodies
    PARAMETERS = 2
    ALL = 3  # by the states, too


class FollowedSlopes:
    """The slopes at the point of a descent; those that are not taken there follow its steps (`Slopes.secant`).

    Args:
        replay: windows and model.
        settings: sizes of the steps, and when slopes are refreshed.
        point: where the descent begins.
        known: slopes there by the states and the first parameters, which need no simulation then.

    Attributes:
        now: the slopes.
        fresh: which of them were taken at the point.
    """

    def __init__(self, replay: Replay, settings: SolverSettings, point: Point, known: Slopes | None) -> None:
        self._replay, self._settings, self._space = replay, settings, replay.model.space
        self._columns = np.arange(len(self._space.parameters))
        self._bodies = np.array([p.prior is not None for p in self._space.parameters], bool)
        self.now = self._first(point, known)
        self.fresh = Fresh.ALL if known is None else Fresh.NONE

    def renew(self, point: Point, which: Fresh) -> None:
        """Take so many of the slopes at the point of the descent."""
        states = which == Fresh.ALL
        columns = self._columns[~self._bodies] if which == Fresh.MOST else self._columns
        found = quick_differences(self._replay, self._settings, point, states=states, columns=columns)
        count, parameter = self._replay.nstate if states else 0, self.now.parameter.copy()
        parameter[..., columns] = found[..., count:]
        self.now, self.fresh = Slopes(found[..., :count] if states else self.now.state, parameter), which

    def follow(self, before: Point, after: Point, nearby: Slopes, asked: Fresh) -> None:
        """Go with a step; slopes that are not asked for follow it unless windows were mended, whose are `nearby`.

        By the states they are taken anew where the step went far, too.
        """
        if asked:
            far = before.cost - after.cost > self._settings.refresh * before.cost
            self.now = nearby
            self.renew(after, Fresh.ALL if far and asked == Fresh.PARAMETERS else asked)
            return
        if nearby is self.now:
            move = self._space.to_unit(after.z) - self._space.to_unit(before.z)
            nearby = nearby.secant(after.residuals - before.residuals, after.delta - before.delta, move)
        self.now, self.fresh = nearby, Fresh.NONE

    def asked(self, gain: float, predicted: float) -> Fresh:
        """Which slopes must be taken anew after a step that gains so much, where so much was predicted.

        Beside an effect, which bends more, slopes by the many parameters of bodies hold for a while.
        """
        if gain >= self._settings.foretold * predicted:
            return Fresh.NONE
        lazy = self._bodies.any() and self._replay.model.effects and gain >= self._settings.foreseen * predicted
        return Fresh.MOST if lazy else Fresh.PARAMETERS

    def _first(self, point: Point, known: Slopes | None) -> Slopes:
        given = 0 if known is None else known.parameter.shape[2]
        columns, states = self._columns[given:], known is None
        found = quick_differences(self._replay, self._settings, point, states=states, columns=columns)
        if known is None:
            return Slopes(found[..., : self._replay.nstate], found[..., self._replay.nstate :])
        return Slopes(known.state, np.concatenate([known.parameter, found], axis=2))
