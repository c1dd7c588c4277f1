"""Rank the catalogue: every effect at every site, fitted and scored on held-out windows."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from threading import Event

import mujoco
import numpy as np

from dr_lab.diagnosis.evidence import Gain, paired_gain
from dr_lab.diagnosis.fit import Fit, Fitter
from dr_lab.diagnosis.identifiability import Identifiability, identifiability
from dr_lab.diagnosis.replay import Replay
from dr_lab.diagnosis.score import Score, score_of
from dr_lab.diagnosis.settings import EvidenceSettings, SolverSettings
from dr_lab.diagnosis.states import StateFit, fit_states
from dr_lab.diagnosis.windows import Windows
from dr_lab.effects.effect import Effect, PlacedEffect, Scales, place
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Explained:
    """A model fitted to the fit windows and scored on the held-out ones.

    Attributes:
        model: the model with its effects.
        fit: context and states on the fit windows.
        states: states on the held-out windows.
        held_out: score there.
    """

    model: Model
    fit: Fit
    states: StateFit
    held_out: Score


@dataclass(frozen=True)
class Candidate:
    """One effect at one site, compared with the same model without it.

    Attributes:
        effect: the placed effect.
        explained: the model with the effect.
        gain: paired gain over the model without it.
        identifiability: what the data can say of it.
    """

    effect: PlacedEffect
    explained: Explained
    gain: Gain
    identifiability: Identifiability


@dataclass(frozen=True)
class Bench:
    """The data and settings on which models are compared.

    Attributes:
        fit: windows that parameters are fitted on.
        held_out: windows that only score.
        solver: settings of the fits.
        evidence: settings of the comparison.
        threads: threads in all.
    """

    fit: Windows
    held_out: Windows
    solver: SolverSettings
    evidence: EvidenceSettings
    threads: int


def explain(bench: Bench, model: Model, start: Array, delta: Array | None = None) -> Explained:
    """Fit a model from a context, and states if given, and score it."""
    fit = Fitter(Replay(model, bench.fit, bench.threads), bench.solver).run(start, delta)
    return Explained(model, fit, *_held_out(bench, model, fit, bench.threads))


def _held_out(
    bench: Bench, model: Model, fit: Fit, threads: int, near: StateFit | None = None, stop: Event | None = None
) -> tuple[StateFit, Score]:
    replay, states = fit_states(model, fit.z, bench.held_out, bench.solver, threads, near, stop)
    return states, score_of(replay, states)


def candidates(
    model: Model, effects: Mapping[str, Effect], scales: Scales, compiled: mujoco.MjModel
) -> tuple[PlacedEffect, ...]:
    """Every effect of the catalogue at every site of the model that it does not hold yet."""
    taken = {effect.label for effect in model.effects}
    placed = [place(effect, compiled, site, scales) for effect in effects.values() for site in effect.sites(compiled)]
    return tuple(p for p in placed if p.label not in taken)


def rank(
    bench: Bench, base: Explained, placed: Sequence[PlacedEffect], done: Callable[[str], None]
) -> tuple[Candidate, ...]:
    """Fit and score every candidate beside the base, most held-out evidence first, then the fewest parameters.

    Candidates run side by side, one thread each, so that no core is asked for twice; those with the most parameters,
    which take longest, begin. `done` is told each label. A failure or Ctrl-C ends all of them at their next simulation.
    """
    stop = Event()

    def work(effect: PlacedEffect) -> Candidate:
        candidate = _try(bench, base, effect, stop)
        done(effect.label)
        return candidate

    with ThreadPoolExecutor(bench.threads) as pool:
        jobs = [pool.submit(work, effect) for effect in sorted(placed, key=lambda p: -len(p.parameters))]
        try:
            for job in as_completed(jobs):
                job.result()
        except BaseException:
            stop.set()
            pool.shutdown(cancel_futures=True)
            raise
    found = [job.result() for job in jobs]
    return tuple(sorted(found, key=lambda c: (-c.gain.total, len(c.effect.parameters))))


def _try(bench: Bench, base: Explained, effect: PlacedEffect, stop: Event) -> Candidate:
    """Fit one candidate from absent and from its further starts, all from the base's solution.

    At absent the model is the base, so the base's slopes are the candidate's; away from it a short run shows whether
    the start is worth going on from.
    """
    model = base.model.with_effect(effect)
    fitter = Fitter(Replay(model, bench.fit, 1, stop), bench.solver)
    absent = np.append(base.fit.z, [p.nominal for p in effect.parameters])
    fits = [fitter.run(absent, base.fit.delta, base.fit.slopes)]
    known = [identifiability(fits[0].first, len(effect.parameters))]
    for start in effect.starts:
        z = model.space.vector(dict(zip(model.space.names, absent, strict=True)) | dict(start))
        rough = fitter.run(z, base.fit.delta, base.fit.slopes, bench.solver.start_iterations)
        known.append(identifiability(rough.first, len(effect.parameters)))
        if rough.order < min(f.order for f in fits):
            fits.append(fitter.run(rough.z, rough.delta))
    fit = min(fits, key=lambda f: f.order)
    explained = Explained(model, fit, *_held_out(bench, model, fit, 1, base.states, stop))
    gain = paired_gain(base.held_out, explained.held_out, bench.evidence)
    return Candidate(effect, explained, gain, max(known, key=lambda i: i.alone))
