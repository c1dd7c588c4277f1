"""The data on which models are compared, and a model fitted and scored there."""

from dataclasses import dataclass, replace
from threading import Event
from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from dr_lab.diagnosis.evidence.left_out import left_out
from dr_lab.diagnosis.evidence.score import Score, score_of
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import StateFit, fit_states
from dr_lab.diagnosis.settings import EvidenceSettings, SolverSettings
from dr_lab.diagnosis.windows.blocks import spread
from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array

Rows = NDArray[np.intp]
_MOST = 1.0 - 1e-9  # share of a cost that can be gained; its logarithm is finite
_LEAST = 1e-9


@dataclass(frozen=True)
class FittedModel:
    """A model fitted to the fit windows and scored on the held-out ones.

    Attributes:
        model: the model with its effects.
        fit: context and states on the fit windows.
        states: states on the held-out windows.
        held_out: score there.
        apart: whether the held-out windows are others than the fit windows, so that they tell more than the fit does.
    """

    model: Model
    fit: Fit
    states: StateFit
    held_out: Score
    apart: bool = True

    def values(self) -> dict[str, float]:
        """The fitted context by parameter name."""
        return self.model.space.mapping(self.fit.z)


@dataclass(frozen=True)
class Bench:
    """The data and settings on which models are compared.

    Attributes:
        fit: windows that parameters are fitted on.
        held_out: windows that only score; `fit` itself where no log is held out.
        solver: settings of the fits.
        evidence: settings of the comparison.
        threads: threads in all.
        timing_resolution: s, step of the model as given, or the wait between commands that were logged more slowly than
            they changed; a shift in time that is smaller cannot be told from it.
        confirms: held-out windows that choose nothing; None where none are left for that.
        colour: residuals of the model that others are compared with which tell as much as one independent one does.
    """

    fit: Windows
    held_out: Windows
    solver: SolverSettings
    evidence: EvidenceSettings
    threads: int
    timing_resolution: float = 0.0
    confirms: Windows | None = None
    colour: float = 1.0

    def beside(self, base: FittedModel) -> "Bench":
        """The bench on which models are compared with this one, whose residuals tell how many are independent."""
        return replace(self, colour=base.held_out.colour)

    @property
    def apart(self) -> bool:
        """Whether logs are held out, so that others score than were fitted."""
        return self.held_out is not self.fit

    @property
    def scored(self) -> str:
        """The logs that score, in words."""
        return "held-out logs" if self.apart else "fit logs"

    @property
    def samples(self) -> int:
        """Number of samples that are fitted."""
        return sum(int(s.fitted.sum()) * s.channel.size for s in self.fit.samples)

    @property
    def enough(self) -> float:
        """Evidence on the fit windows that is believed."""
        return self.evidence.enough_hope * self.evidence.threshold

    @property
    def hope(self) -> float:
        """Evidence on the fit windows that a linear step must promise."""
        return self.evidence.least_hope * self.evidence.threshold

    def screened(self, base: Fit | None = None) -> Rows:
        """Fit windows on which candidates are looked at and tried.

        They are spread evenly over the windows, in order of the cost that a model leaves in each, the worst one among
        them; without a model in order of time. So an effect is seen that acts in few windows, as an end stop does. Logs
        with a load and without it have their shares.

        Args:
            base: the model's fit to all windows.
        """
        count = len(self.fit)
        asked = round(self.evidence.screen_seconds / self.fit.length)
        most = min(count, max(asked, self.evidence.screen_windows))
        left = np.zeros(count) if base is None else _left(base)
        every = np.lexsort((left, self.fit.loaded))
        return np.sort(every[spread(count, most)])

    def promise(self, gain: float, base: Fit, extra: int = 0) -> float:
        """Evidence on all fit windows that a lower cost foretells, −n ln(1 − share), less the penalty of chance.

        It is Δχ² of residuals of unknown size, n of them independent. What is left is as coloured as the base's
        residuals where nothing is gained, and white where all above the noise is.

        Args:
            gain: by how much the cost of a fit of some or all of these windows could fall.
            base: that fit.
            extra: number of parameters that may owe something to chance on its windows.
        """
        level = base.cost / (self.samples * len(base.delta) / len(self.fit))
        share = float(np.clip(gain / base.cost, 0.0, _MOST))
        return self._evidence(share, level) - self.evidence.penalty * extra

    def _evidence(self, share: float, level: float) -> float:
        """−n ln(1 − share) of a base whose residuals are so large, as χ²."""
        left = 1 - min(share / max(1 - 1 / max(level, 1.0), _LEAST), 1.0)
        return -self.samples / (1 + (self.colour - 1) * left) * float(np.log1p(-share))

    @property
    def negligible_share(self) -> float:
        """Share of the cost of a fit of all windows by which the deviance falls by the solver's tolerance."""
        return self.solver.tolerance * self.colour / self.samples

    def cost_at(self, fit: Fit, evidence: float) -> float:
        """Cost that is worse by so much evidence than that of a fit of all windows; ∞ if the fit leaves some out."""
        return np.inf if fit.infeasible.any() else fit.cost * float(np.exp(evidence * self.colour / self.samples))

    def hoped(self, base: Fit) -> float:
        """Cost of a fit of all windows that promises just what is hoped for beside a base; ∞ as in `cost_at`."""
        if base.infeasible.any():
            return np.inf
        level = base.cost / self.samples
        if self._evidence(_MOST, level) <= self.hope:
            return 0.0
        share = cast(float, brentq(lambda share: self._evidence(share, level) - self.hope, 0.0, _MOST))
        return base.cost * (1 - share)

    def screening(self, base: Fit | None = None) -> "Bench":
        """The bench with the windows of `screened` to fit; itself where there are no more."""
        rows = self.screened(base)
        return self if len(rows) == len(self.fit) else replace(self, fit=self.fit.pick(rows))


def fit_and_score(
    bench: Bench, model: Model, start: Array, delta: Array | None = None, goal: float = np.inf
) -> FittedModel:
    """Fit a model from a context, and states if given, and score it; of a `goal` see `Fitter.run`."""
    return scored(bench, model, fitted(bench, model, start, delta, goal))


def fitted(bench: Bench, model: Model, start: Array, delta: Array | None = None, goal: float = np.inf) -> Fit:
    """Fit a model as `fit_and_score` does; to few windows first where bodies, whose slopes are dear, are free."""
    replay, few = Replay(model, bench.fit, bench.threads), bench.screening()
    if not model.inertials or few is bench or delta is not None:
        return Fitter(replay, bench.solver).run(start, delta, goal=goal)
    part = Fitter(Replay(model, few.fit, bench.threads), bench.solver, rough=True).run(start)
    states = np.zeros((len(bench.fit), replay.nstate))
    states[bench.screened()] = part.delta
    fitter = Fitter(replay, bench.solver)
    return fitter.rerun(fitter.begin(part.z, states), goal=goal)


def fitted_to_the_end(bench: Bench, fitted_model: FittedModel) -> FittedModel:
    """A model whose fit goes on by exact slopes and crawls for longer (`SolverSettings.patient`).

    Candidates need not end as low as they can to be compared; what others are compared with, and whose parameters are
    told with their standard deviations, ends lower. A fit by exact slopes stays as it is where it converged, or where
    shapes touch: among their jags no certificate comes.
    """
    fit, replay = fitted_model.fit, Replay(fitted_model.model, bench.fit, bench.threads)
    if replay.quick is replay and (fit.converged or replay.touching):
        return fitted_model
    further = Fitter(replay.exact(), bench.solver.patient).run(fit.z, fit.delta)
    if further.order > fit.order:
        return fitted_model
    return scored(bench, fitted_model.model, further, near=fitted_model.states)


def fitted_for_comparison(bench: Bench, fitted_model: FittedModel) -> FittedModel:
    """A model that others are compared with: fitted to the end but where bodies are free, whose slopes are dear.

    Of those only the model that is the answer goes on: what lies between is little beside what an effect must gain.
    """
    return fitted_model if fitted_model.model.inertials else fitted_to_the_end(bench, fitted_model)


def beyond_doubt(bench: Bench, fitted_model: FittedModel) -> float:
    """Cost above which another model is worse than a fitted one without a doubt; see `Fitter.run`."""
    return bench.beside(fitted_model).cost_at(fitted_model.fit, bench.enough)


def fitted_alone(replay: Replay, fit: Fit) -> FittedModel:
    """A fit scored on the windows that it was fitted to, which takes no simulation and flatters it."""
    states = _states(fit)
    return FittedModel(replay.model, fit, states, score_of(replay, states), apart=False)


def scored(
    bench: Bench,
    model: Model,
    fit: Fit,
    threads: int | None = None,
    near: StateFit | None = None,
    stop: Event | None = None,
) -> FittedModel:
    """Score a fit on the held-out windows; `near` are states there of a similar model, `stop` ends it from outside."""
    replay, states = fit_states(model, fit.z, bench.held_out, bench.solver, threads or bench.threads, near, stop)
    score = score_of(replay, states)
    if bench.apart:
        fitted = Replay(model, bench.fit, threads or bench.threads, stop)
        found = left_out(fitted, fit, bench.solver, bench.evidence)
        others = replace(_states(fit), residuals=found.residuals, infeasible=found.infeasible)
        score = replace(score, foretold=score_of(fitted, others))
    return FittedModel(model, fit, states, score, bench.apart)


def _left(fit: Fit) -> Array:
    """Cost of each window; of those that diverge, of which it is not known, that of the median window."""
    known = ~fit.infeasible
    return np.where(known, fit.window_costs, np.median(fit.window_costs[known]) if known.any() else 0.0)


def _states(fit: Fit) -> StateFit:
    return StateFit(fit.z, fit.delta, fit.residuals, fit.cost, fit.infeasible, fit.slopes.state)
