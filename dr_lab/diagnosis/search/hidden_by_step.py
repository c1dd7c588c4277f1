"""What the time step does to a fitted model, beside what a richer law would change."""

from dataclasses import replace

import numpy as np

from dr_lab.diagnosis.checks.numerical_floor import in_parts
from dr_lab.diagnosis.checks.step_error import step_error
from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, fit_and_score
from dr_lab.diagnosis.fit.replay import Mask, Replay
from dr_lab.diagnosis.fit.solved import solved
from dr_lab.diagnosis.windows.finer import finer
from dr_lab.trajectory import Array

_FINER = 4  # parts of the step, by which what it does is a quarter


def hidden_by_step(bench: Bench, poorer: FittedModel, richer: FittedModel) -> bool:
    """Whether the time step does at least half of what a richer law changes, and so at a quarter of the step.

    What a step does falls with it, and so does what a law changes that makes up for it; what a law does of its own
    stays. Both models are fitted anew at the finer step, which only those are asked for that the step seems to hide.
    """
    if not _does_half(bench, poorer, richer):
        return False
    held_out = finer(bench.held_out, _FINER)
    fine = replace(bench, fit=finer(bench.fit, _FINER) if bench.apart else held_out, held_out=held_out)
    return _does_half(fine, *(_refitted(fine, each) for each in (poorer, richer)))


def _refitted(fine: Bench, fitted_model: FittedModel) -> FittedModel:
    """A model at the step of finer windows."""
    model, fit = in_parts(fitted_model.model, _FINER), fitted_model.fit
    return fit_and_score(fine, model, fit.z, fit.delta)


def _does_half(bench: Bench, poorer: FittedModel, richer: FittedModel) -> bool:
    """Whether the time step does at least half of what a richer law changes.

    c·e ≥ c·c / 2 over the windows that score and that both simulate, c = r − r' being the difference of the two
    models' residuals, and e the error of the poorer one's step: so the step explains half of c, if not
    more, the way that c goes. What the step does besides, parameters may take up.
    """
    replay = Replay(poorer.model, bench.held_out, bench.threads)
    error, diverged = _not_taken_up(replay, poorer, bench)
    used = replay.scored & ~(diverged | poorer.states.infeasible | richer.states.infeasible)[:, None]
    change, error = (poorer.states.residuals - richer.states.residuals)[used], error[used]
    return bool(used.any() and change @ error >= change @ change / 2)


def _not_taken_up(replay: Replay, fitted_model: FittedModel, bench: Bench) -> tuple[Array, Mask]:
    """`step_error` of the windows that score, without what other starts take up; and which windows diverge (w,).

    That is, to first order, S (SᵀS + P)⁻¹ Sᵀ of it, S being the slopes of the fitted residuals by the states, P the
    precision of their prior.
    """
    states = fitted_model.states
    error, diverged = step_error(replay, states, bench.threads)
    slopes = np.where(replay.fitted[..., None], states.slopes, 0.0)
    pull = slopes.transpose(0, 2, 1) @ np.where(replay.fitted, error, 0.0)[..., None]
    hessian = slopes.transpose(0, 2, 1) @ slopes + np.diag(bench.held_out.prior.std**-2.0)
    taken = states.slopes @ solved(hessian, pull)
    return error - taken[..., 0], diverged
