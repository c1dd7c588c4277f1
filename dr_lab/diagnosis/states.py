"""Initial states of windows at a fixed context: one small Levenberg–Marquardt per window, all windows in one batch."""

from dataclasses import dataclass, replace
from threading import Event

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from dr_lab.diagnosis.point import Point, better_start, huber_weights, take, window_costs
from dr_lab.diagnosis.replay import Replay
from dr_lab.diagnosis.settings import SolverSettings
from dr_lab.diagnosis.slopes import differences
from dr_lab.diagnosis.windows import Windows
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array

_NO_PARAMETER = np.zeros(0, np.intp)
_PLAUSIBLE = 0.999  # probability below which a window's χ² passes for noise


@dataclass(frozen=True)
class StateFit(Point):
    """States at which every window's own cost is lowest.

    Attributes:
        slopes: ∂r/∂δ at the last linearisation, shape (w, m, s).
    """

    slopes: Array


def fit_states(
    model: Model,
    z: Array,
    windows: Windows,
    solver: SolverSettings,
    threads: int | None = None,
    near: StateFit | None = None,
    stop: Event | None = None,
) -> tuple[Replay, StateFit]:
    """Fit only the windows' initial states at a context, from the samples that windows allow.

    Each window minimises ‖(y − ŷ(z, x_w))/σ‖²_Huber + ‖(x_w − x̄_w)/s‖² on its own, with its own damping.

    Args:
        model: the model.
        z: its context, shape (n,).
        windows: the windows.
        solver: settings.
        threads: C threads; None takes every core.
        near: such a fit of a similar model, whose states and slopes make a good start in most windows.
        stop: see `Replay`.
    """
    replay = Replay(model, windows, threads, stop)
    return replay, _Search(replay, solver, z).run(near)


def polished(replay: Replay, solver: SolverSettings, point: Point, slopes: Array) -> StateFit:
    """The states of a point fitted anew at its context, each window with a damping of its own.

    Where a joint step is hindered by a few windows whose states meet a kink (a joint that sticks, a contact), all
    others must go in short steps with them; this lets each go its own way.

    Args:
        replay: windows and model.
        solver: settings.
        point: context and states to start from.
        slopes: ∂r/∂δ nearby, shape (w, m, s).
    """
    return _Search(replay, solver, point.z).descend(point, slopes, ~point.infeasible)


class _Search:
    """State of the search over all windows of one replay."""

    def __init__(self, replay: Replay, settings: SolverSettings, z: Array) -> None:
        self.replay = replay
        self.settings = settings
        self.z = z
        self.precision = replay.windows.prior.std**-2.0

    def run(self, near: StateFit | None) -> StateFit:
        """The best states, from the prior's mean or from near; where near led to poor ones, from the mean as well."""
        mean = self._point(np.zeros((len(self.replay.windows), self.replay.nstate)))
        if near is None:
            return self.descend(mean, None, ~mean.infeasible)
        first = better_start(mean, self._point(near.delta), self._weights(mean), self.precision)
        found = self.descend(first, near.slopes, ~first.infeasible)
        poor = self._poor(found) & ~mean.infeasible
        return self._better(found, self.descend(mean, None, poor)) if poor.any() else found

    def _poor(self, found: StateFit) -> NDArray[np.bool_]:
        """Windows whose χ² noise alone would hardly leave."""
        fitted = self.replay.fitted
        return np.where(fitted, found.residuals**2, 0.0).sum(1) > chi2.ppf(_PLAUSIBLE, np.maximum(fitted.sum(1), 1))

    def _better(self, one: StateFit, other: StateFit) -> StateFit:
        """The better of two fits in each window."""
        weight = self._weights(one)
        chosen = one.infeasible | (self._costs(other, weight) < self._costs(one, weight))
        chosen &= ~other.infeasible
        point = replace(take(one, other, chosen), infeasible=one.infeasible & ~chosen)
        slopes = np.where(chosen[:, None, None], other.slopes, one.slopes)
        total = float(self._costs(point, self._weights(point)).sum())
        return StateFit(point.z, point.delta, point.residuals, total, point.infeasible, slopes)

    def descend(self, point: Point, known: Array | None, active: NDArray[np.bool_]) -> StateFit:
        """Levenberg–Marquardt in the active windows, from slopes that may be those of a point nearby."""
        settings, count = self.settings, len(self.replay.windows)
        slopes = self._slopes(point) if known is None else known
        stale, damping = np.full(count, known is not None), np.full(count, settings.damping)
        for _ in range(settings.iterations):
            weight = self._weights(point)
            cost = self._costs(point, weight)
            trial = self._point(point.delta + self._steps(point, slopes, weight, damping, active))
            gain = np.where(trial.infeasible, -np.inf, cost - self._costs(trial, weight))
            better = active & (gain >= 0)
            failed = active & ~better
            point = take(point, trial, better)
            damping = np.where(better, damping / settings.damping_down, damping)
            damping = np.where(failed & ~stale, damping * settings.damping_up, damping)
            renew = (failed & stale) | (better & (gain > settings.refresh * cost))
            stale |= better
            active &= ~(better & (gain <= settings.tolerance * cost)) & (damping < settings.damping_max)
            if not active.any():
                break
            if (active & renew).any():
                slopes, stale = self._slopes(point), np.zeros(count, bool)
        total = float(self._costs(point, self._weights(point)).sum())
        return StateFit(point.z, point.delta, point.residuals, total, point.infeasible, slopes)

    def _weights(self, point: Point) -> Array:
        return huber_weights(point.residuals, self.replay.fitted, point.infeasible, self.settings.huber)

    def _point(self, delta: Array) -> Point:
        residuals, infeasible = self.replay.residuals(self.z[None], delta[None])
        return Point(self.z, delta, residuals[0], np.inf, infeasible[0])

    def _slopes(self, point: Point) -> Array:
        return differences(self.replay, self.settings, point, states=True, columns=_NO_PARAMETER)

    def _costs(self, point: Point, weight: Array) -> Array:
        return window_costs(point, weight, self.precision)

    def _steps(self, point: Point, slopes: Array, weight: Array, damping: Array, active: NDArray[np.bool_]) -> Array:
        weighted = (slopes * weight[..., None]).transpose(0, 2, 1)
        hessian = weighted @ slopes + np.diag(self.precision)
        gradient = (weighted @ point.residuals[..., None])[..., 0] + self.precision * point.delta
        diagonal = np.einsum("wii->wi", hessian)
        damped = hessian + (damping[:, None] * diagonal)[:, :, None] * np.eye(hessian.shape[1])
        return np.where(active[:, None], -np.linalg.solve(damped, gradient[..., None])[..., 0], 0.0)
