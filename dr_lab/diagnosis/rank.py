"""Rank the catalogue: every effect at every site, looked at, fitted where worth it, scored on held-out windows."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from threading import Event
from typing import TypeVar

from dr_lab.diagnosis.evidence import Gain, paired_gain
from dr_lab.diagnosis.fit import Fit, Fitter
from dr_lab.diagnosis.identifiability import Identifiability
from dr_lab.diagnosis.replay import Replay
from dr_lab.diagnosis.score import Score, score_of
from dr_lab.diagnosis.screen import Look, look
from dr_lab.diagnosis.settings import EvidenceSettings, SolverSettings
from dr_lab.diagnosis.states import StateFit, fit_states
from dr_lab.diagnosis.windows import Windows
from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array

_In = TypeVar("_In")
_Out = TypeVar("_Out")


@dataclass(frozen=True)
class Explained:
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


@dataclass(frozen=True)
class Candidate:
    """One effect at one site, compared with the same model without it.

    Attributes:
        effect: the placed effect.
        explained: the model with the effect.
        gain: paired gain over the model without it.
        identifiability: what the data can say of it.
        predicted: share of the cost on the fit windows that a linear step could remove.
    """

    effect: PlacedEffect
    explained: Explained
    gain: Gain
    identifiability: Identifiability
    predicted: float

    @property
    def fitted(self) -> bool:
        """Whether the effect was fitted; else it stayed absent, as its prediction was too small."""
        return self.explained.fit.iterations > 0


@dataclass(frozen=True)
class Bench:
    """The data and settings on which models are compared.

    Attributes:
        fit: windows that parameters are fitted on.
        held_out: windows that only score; `fit` itself where no log is held out.
        solver: settings of the fits.
        evidence: settings of the comparison.
        threads: threads in all.
        timing_resolution: s, step of the model as given; a timing effect that is smaller cannot be told from it.
    """

    fit: Windows
    held_out: Windows
    solver: SolverSettings
    evidence: EvidenceSettings
    threads: int
    timing_resolution: float = 0.0

    @property
    def apart(self) -> bool:
        """Whether logs are held out, so that others score than were fitted."""
        return self.held_out is not self.fit

    @property
    def scored(self) -> str:
        """The logs that score, in words."""
        return "held-out logs" if self.apart else "fit logs"


def explain(bench: Bench, model: Model, start: Array, delta: Array | None = None) -> Explained:
    """Fit a model from a context, and states if given, and score it."""
    fit = Fitter(Replay(model, bench.fit, bench.threads), bench.solver).run(start, delta)
    return Explained(model, fit, *_held_out(bench, model, fit, bench.threads), bench.apart)


def _held_out(
    bench: Bench, model: Model, fit: Fit, threads: int, near: StateFit | None = None, stop: Event | None = None
) -> tuple[StateFit, Score]:
    replay, states = fit_states(model, fit.z, bench.held_out, bench.solver, threads, near, stop)
    return states, score_of(replay, states)


def rank(
    bench: Bench, base: Explained, placed: Sequence[PlacedEffect], done: Callable[[str], None]
) -> tuple[Candidate, ...]:
    """Look at every candidate beside the base, fit those worth it, score; the most held-out evidence comes first.

    A linear step at absent and at each further start predicts what a candidate could gain. The most promising ones are
    fitted, half of them with a single parameter; where they gain less than predicted, so are those whose prediction
    stands up to that. Equal evidence is ordered by fewest parameters. Candidates run side by side, one thread each, so
    that no core is asked for twice; `done` is told each label. A failure or Ctrl-C ends all of them at their next
    simulation.
    """
    stop, settings = Event(), bench.evidence
    looks = _side_by_side(bench.threads, stop, placed, lambda e: _look(bench, base, e, stop))
    order = sorted(range(len(placed)), key=lambda k: -looks[k].gain)
    found: dict[int, Candidate] = {}

    def finish(k: int) -> Candidate:
        candidate = _try(bench, base, placed[k], looks[k], stop)
        done(placed[k].label)
        return candidate

    reachable = max((look.gain for look in looks), default=0.0)
    for _ in range(2):
        near = [k for k in order if looks[k].gain >= settings.least_promise * reachable] or order[:1]
        wave = _shortlist([k for k in near if k not in found], placed, settings.most_fits - len(found))
        wave.sort(key=lambda k: -len(placed[k].parameters))  # those that take longest begin
        found |= dict(zip(wave, _side_by_side(bench.threads, stop, wave, finish), strict=True))
        reachable = max((c.explained.fit.below(base.fit) for c in found.values()), default=0.0)
    for k in set(order) - found.keys():
        found[k] = _unfitted(base, placed[k], looks[k], bench.evidence)
        done(placed[k].label)
    return tuple(sorted((found[k] for k in order), key=lambda c: (-c.gain.total, len(c.effect.parameters))))


def _shortlist(order: Sequence[int], placed: Sequence[PlacedEffect], most: int) -> list[int]:
    """Of candidates in the order of their promise at most so many: those first, and as many with one parameter.

    Whatever holds another effect promises at least as much; it must not take the simpler one's place.
    """
    half = order[: (most + 1) // 2]
    simple = [k for k in order if len(placed[k].parameters) == 1 and k not in half]
    return list(dict.fromkeys([*half, *simple[: most // 2], *order]))[:most]


def _side_by_side(threads: int, stop: Event, items: Sequence[_In], work: Callable[[_In], _Out]) -> list[_Out]:
    with ThreadPoolExecutor(threads) as pool:
        jobs = [pool.submit(work, item) for item in items]
        try:
            for job in as_completed(jobs):
                job.result()
        except BaseException:
            stop.set()
            pool.shutdown(cancel_futures=True)
            raise
    return [job.result() for job in jobs]


def _fitter(bench: Bench, base: Explained, effect: PlacedEffect, stop: Event) -> Fitter:
    return Fitter(Replay(base.model.with_effect(effect), bench.fit, 1, stop), bench.solver)


def _look(bench: Bench, base: Explained, effect: PlacedEffect, stop: Event) -> Look:
    return look(_fitter(bench, base, effect, stop), effect, base.fit)


def _try(bench: Bench, base: Explained, effect: PlacedEffect, first: Look, stop: Event) -> Candidate:
    """Fit one candidate from the base's solution and from its further starts.

    A short run shows whether a start away from absent is worth going on from.
    """
    fitter = _fitter(bench, base, effect, stop)
    fits = [fitter.run(first.absent.z, base.fit.delta, base.fit.slopes)]
    steps = bench.solver.start_iterations * effect.effect.patience
    for z in first.starts:
        start = fitter.begin(z, base.fit.delta)
        rough = fitter.run(z, start.delta, base.fit.slopes, steps)
        if rough.order < min(f.order for f in fits):
            fits.append(fitter.run(rough.z, rough.delta))
    fit, model = min(fits, key=lambda f: f.order), fitter.replay.model
    explained = Explained(model, fit, *_held_out(bench, model, fit, 1, base.states, stop), bench.apart)
    gain = paired_gain(base.held_out, explained.held_out, bench.evidence)
    return Candidate(effect, explained, gain, first.identifiability, first.gain / base.fit.cost)


def _unfitted(base: Explained, effect: PlacedEffect, first: Look, settings: EvidenceSettings) -> Candidate:
    """A candidate that stays absent, where it is the base."""
    explained = Explained(base.model.with_effect(effect), first.absent, base.states, base.held_out, base.apart)
    gain = paired_gain(base.held_out, base.held_out, settings)
    return Candidate(effect, explained, gain, first.identifiability, first.gain / base.fit.cost)
