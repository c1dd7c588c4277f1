"""Initial states of windows at a fixed context: one small Levenberg–Marquardt per window, all windows in one batch."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from threading import Event

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from dr_lab.diagnosis.fit.active_windows import ActiveWindows
from dr_lab.diagnosis.fit.point import Point, better_start, take, window_costs
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.solved import solved
from dr_lab.diagnosis.settings import SolverSettings
from dr_lab.diagnosis.windows.channels import Tape
from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class StateFit(Point):
    """States at which every window's own cost is lowest.

    Attributes:
        slopes: ∂r/∂δ at each window's last linearisation, shape (w, m, s); 0 behind the last sample of all windows that
            is fitted.
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

    What comes behind these samples is simulated once, at the end.

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
    known = replay.until_known()
    found = _Search(known, solver, z).run(near)
    if known is replay:
        return replay, found
    residuals, infeasible = replay.residuals(z[None], found.delta[None])
    return replay, replace(found, residuals=residuals[0], infeasible=infeasible[0])


def fit_roughly(
    model: Model, z: Array, windows: Windows, solver: SolverSettings, threads: int | None = None
) -> tuple[Replay, StateFit, Tape]:
    """The same, roughly, and what the model does from these states, to the windows' ends.

    A rough fit keeps the slopes at its start as long as its steps gain, and ends at the rough tolerance.
    """
    replay = Replay(model, windows, threads)
    most, tolerance = solver.start_iterations, solver.rough_tolerance
    rough = replace(solver, state_tolerance=tolerance, refresh=1.0, iterations=most)
    found = _Search(replay.until_known(), rough, z).run(None)
    tape, lost = replay.simulate(z[None], found.delta[None])
    residuals, infeasible = replay.compared(z[None], tape, lost)
    return replay, replace(found, residuals=residuals[0], infeasible=infeasible[0]), tape


def polished(
    replay: Replay, solver: SolverSettings, point: Point, slopes: Array, active: NDArray[np.bool_]
) -> StateFit:
    """The states of a point fitted anew at its context, each window with a damping of its own.

    Where a joint step is hindered by a few windows whose states meet a kink (a joint that sticks, a contact), all
    others must go in short steps with them; this lets each go its own way, for `settings.polish_iterations` steps: the
    joint steps that follow go on from there.

    Args:
        replay: windows and model.
        solver: settings.
        point: context and states to start from.
        slopes: ∂r/∂δ nearby, shape (w, m, s).
        active: windows in which that is done, shape (w,).
    """
    return _Search(replay, solver, point.z).descend(point, slopes, active, solver.polish_iterations)


def restarted(
    replay: Replay, solver: SolverSettings, point: Point, slopes: Array, windows: NDArray[np.bool_]
) -> StateFit:
    """The states of a point; in some windows (w,) sought from their prior's mean, where they end lower from there.

    Arguments as for `polished`.
    """
    search = _Search(replay, solver, point.z)
    return search.anew(StateFit(point.z, point.delta, point.residuals, point.cost, point.infeasible, slopes), windows)


class _Search:
    """State of the search over all windows of one replay, or over their first parts, of so many s."""

    def __init__(self, replay: Replay, settings: SolverSettings, z: Array, first: float = np.inf) -> None:
        self.replay = replay
        self.settings = settings
        self.z = z
        self.precision = replay.windows.prior.std**-2.0
        self._time = np.concatenate([np.repeat(s.time, s.channel.size, axis=1) for s in replay.windows.samples], axis=1)
        self._counts = self._time <= first

    def run(self, near: StateFit | None) -> StateFit:
        """The best states, from the prior's mean or from near; where that leads to poor ones, from elsewhere, too."""
        mean, slopes = self.point(np.zeros((len(self.replay.windows), self.replay.nstate))), None
        first = mean
        if near is not None:
            first, slopes = better_start(mean, self.point(near.delta), self._weights(mean), self.precision), near.slopes
        found = self.descend(first, slopes, ~first.infeasible)
        if not self.replay.touching:
            return self.anew(found, self._poor(found, 1.0))
        if near is not None:
            found = self.restarted(found, mean, self._poor(found, self._usual(found)))
        return self._drawn(found)

    def anew(self, found: StateFit, windows: NDArray[np.bool_]) -> StateFit:
        """The states; those of some windows sought from their prior's mean, by longer and longer first parts of them.

        Where a long motion is chaotic, as that of a pendulum which tumbles, its end hangs on its start by a maze of
        valleys, its first part by one. An impact is no such thing: among contacts the whole window is taken at once.
        """
        if not windows.any():
            return found
        start = self.point(np.where(windows[:, None], 0.0, found.delta))
        if not self.replay.touching:
            last = self._time[self.replay.fitted].max()
            first = self.settings.first_part * last
            while first < last:
                part = _Search(self.replay, self.settings, self.z, first)
                start, first = part.descend(start, None, windows & ~start.infeasible), 2 * first
        return self.restarted(found, start, windows)

    def _drawn(self, found: StateFit) -> StateFit:
        """The states; in windows that are stuck among contacts, whose jags hold a search, sought from draws.

        Of many draws each such window begins at the one that costs least.
        """
        settings, random = self.settings, np.random.default_rng(0)
        for _ in range(settings.redrawn):
            stuck = self._left(found) > settings.stuck * self._usual(found)
            if not stuck.any():
                break
            part = ActiveWindows(self.replay, np.arange(len(stuck)), settings).narrowed(stuck)
            size = (settings.draws, *found.delta.shape)
            drawn = settings.spread * self.replay.windows.prior.std * random.standard_normal(size)
            tried = part.tried(found, np.where(stuck[:, None], drawn - found.delta, 0.0))
            start, _, _ = self._lowest(tried, self._weights(found))
            found = self.restarted(found, start, stuck)
        return found

    def restarted(self, found: StateFit, start: Point, windows: NDArray[np.bool_]) -> StateFit:
        """The better of states and of those to which a search in some windows leads from another start."""
        active = windows & ~start.infeasible
        return self._better(found, self.descend(start, None, active)) if active.any() else found

    def _poor(self, found: StateFit, usual: float) -> NDArray[np.bool_]:
        """Windows whose χ² noise would hardly leave, where it is as large as it usually is."""
        count = np.maximum((self.replay.fitted & ~found.infeasible[:, None]).sum(1), 1)
        return self._left(found) > usual * chi2.ppf(self.settings.plausible, count) / count

    def _left(self, found: StateFit) -> Array:
        """χ² of each window's fitted samples, (w,); 0 of one that diverges."""
        fitted = self.replay.fitted & ~found.infeasible[:, None]
        return np.where(fitted, found.residuals**2, 0.0).sum(1) / np.maximum(fitted.sum(1), 1)

    def _usual(self, found: StateFit) -> float:
        """That of the median window that does not diverge; 1 at least."""
        return max(1.0, float(np.median(self._left(found)[~found.infeasible]))) if not found.infeasible.all() else 1.0

    def _better(self, one: StateFit, other: StateFit) -> StateFit:
        """The better of two fits in each window."""
        weight = self._weights(one)
        chosen = one.infeasible | (self._costs(other, weight) < self._costs(one, weight))
        chosen &= ~other.infeasible
        point = replace(take(one, other, chosen), infeasible=one.infeasible & ~chosen)
        slopes = np.where(chosen[:, None, None], other.slopes, one.slopes)
        total = float(self._costs(point, self._weights(point)).sum())
        return StateFit(point.z, point.delta, point.residuals, total, point.infeasible, slopes)

    def descend(
        self, point: Point, known: Array | None, active: NDArray[np.bool_], most: int | None = None
    ) -> StateFit:
        """Levenberg–Marquardt in the active windows, at most so many steps, from slopes that may be those nearby."""
        settings, count = self.settings, len(self.replay.windows)
        part = ActiveWindows(self.replay, np.arange(count), settings).narrowed(active)
        slopes = part.renew(point, np.zeros((*point.residuals.shape, self.replay.nstate))) if known is None else known
        stale, damping = np.full(count, known is not None), np.full(count, settings.damping)
        for _ in range(settings.iterations if most is None else most):
            weight = self._weights(point)
            cost = self._costs(point, weight)
            trial, left, tried = self._best(part, point, slopes, weight, damping, active)
            gain = cost - left
            better = active & (gain >= 0)
            failed = active & ~better
            forced = better & stale & (tried > damping)  # more damping hid that the slopes are old
            point = take(point, trial, better)
            damping = np.where(better, tried / settings.damping_down, damping)
            damping = np.where(failed & ~stale, damping * settings.damping_up**part.at_once, damping)
            renew = (failed & stale) | forced | (better & (gain > settings.refresh * cost))
            stale |= better
            done = better & ~forced & (gain <= settings.state_tolerance * cost)
            active &= ~done & (damping < settings.damping_max)
            if not active.any():
                break
            part = part.narrowed(active)
            if (active & renew).any():
                few = part.narrowed(active & renew)
                slopes = few.renew(point, slopes)
                stale[few.rows] = False
        total = float(self._costs(point, self._weights(point)).sum())
        return StateFit(point.z, point.delta, point.residuals, total, point.infeasible, slopes)

    def _best(
        self, part: ActiveWindows, point: Point, slopes: Array, weight: Array, damping: Array, active: NDArray[np.bool_]
    ) -> tuple[Point, Array, Array]:
        """The best of the steps that are tried at once in each window, its cost there and its damping, (w,) each."""
        dampings = damping * self.settings.damping_up ** np.arange(part.at_once)[:, None]
        steps = [self._steps(point, slopes, weight, each, active) for each in dampings]
        best, costs, first = self._lowest(part.tried(point, np.stack(steps)), weight)
        return best, costs, dampings[first, np.arange(len(damping))]

    def _lowest(self, found: Sequence[Point], weight: Array) -> tuple[Point, Array, NDArray[np.intp]]:
        """In each window the point that costs least, its cost, infinite where all diverge, and its place, (w,) each."""
        costs = np.stack([np.where(each.infeasible, np.inf, self._costs(each, weight)) for each in found])
        first, windows = costs.argmin(0), np.arange(costs.shape[1])
        delta = np.stack([each.delta for each in found])[first, windows]
        residuals = np.stack([each.residuals for each in found])[first, windows]
        return Point(self.z, delta, residuals, np.inf, np.isinf(costs.min(0))), costs.min(0), first

    def _weights(self, point: Point) -> Array:
        return self._counts * self.replay.weights(point.residuals, point.infeasible, self.settings.huber)

    def point(self, delta: Array) -> Point:
        """State corrections (w, s), simulated; of unknown cost."""
        residuals, infeasible = self.replay.residuals(self.z[None], delta[None])
        return Point(self.z, delta, residuals[0], np.inf, infeasible[0])

    def _costs(self, point: Point, weight: Array) -> Array:
        return window_costs(point, weight, self.precision)

    def _steps(self, point: Point, slopes: Array, weight: Array, damping: Array, active: NDArray[np.bool_]) -> Array:
        slopes, steps = slopes[active], np.zeros_like(point.delta)
        weighted = (slopes * weight[active, :, None]).transpose(0, 2, 1)
        hessian = weighted @ slopes + np.diag(self.precision)
        gradient = (weighted @ point.residuals[active, :, None])[..., 0] + self.precision * point.delta[active]
        diagonal = np.einsum("wii->wi", hessian)
        damped = hessian + (damping[active, None] * diagonal)[:, :, None] * np.eye(hessian.shape[1])
        steps[active] = -solved(damped, gradient[..., None])[..., 0]
        return steps
