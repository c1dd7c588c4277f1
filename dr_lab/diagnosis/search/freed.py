"""What a free law beside an effect would leave of the logs that score, by one linear step."""

from dataclasses import replace

import numpy as np

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel
from dr_lab.diagnosis.evidence.score import Score, score_of
from dr_lab.diagnosis.fit.fit import movable
from dr_lab.diagnosis.fit.normal_equations import NormalEquations
from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.prior import prior_precision
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.slopes import Slopes, differences
from dr_lab.diagnosis.fit.solved import solved
from dr_lab.diagnosis.search.free_law import FreeLaw
from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array


def freed_score(bench: Bench, fitted_model: FittedModel, effect: PlacedEffect, free: FreeLaw) -> Score:
    """Score of a fitted model with a free law beside one of its effects, to first order.

    The step Δθ of all parameters and of the free law's is a full one on the fit windows, the states being eliminated.
    On the windows that score the residuals become r + J_θ Δθ + J_x Δx, Δx being the best of each window. A fit is not
    needed: free laws act linearly on forces, and what is left for them is small beside the motion. Nor is it better:
    steps of bodies end at ones that there cannot be, and three of Levenberg–Marquardt reach a third of what is there.

    Args:
        bench: data and settings.
        fitted_model: the fitted model.
        effect: the effect in it.
        free: the free law.
    """
    effects = (free.beside(each) if each.label == effect.label else (each,) for each in fitted_model.model.effects)
    model = replace(fitted_model.model, effects=tuple(part for parts in effects for part in parts))
    fit, own = fitted_model.fit, [p.name for p in free.own]
    moved = _step(bench, fitted_model, _columns(bench, model, fitted_model, fit, bench.fit, own))
    states = fitted_model.states
    named = list(fitted_model.model.space.names)
    slopes = Slopes(states.slopes, _columns(bench, model, fitted_model, states, bench.held_out, named + own))
    shifted = replace(states, residuals=states.residuals + slopes.parameter @ moved)
    replay = Replay(fitted_model.model, bench.held_out, bench.threads)
    return score_of(replay, replace(shifted, residuals=_settled(bench, replay, shifted, slopes)))


def _columns(
    bench: Bench, model: Model, fitted_model: FittedModel, point: Point, windows: Windows, names: list[str]
) -> Array:
    """Slopes of the residuals of windows by parameters of the model with the free law, where that is absent."""
    space = model.space
    at = replace(point, z=space.vector(fitted_model.values()))
    columns = np.array([space.index(name) for name in names])
    return differences(Replay(model, windows, bench.threads), bench.solver, at, states=False, columns=columns)


def _step(bench: Bench, fitted_model: FittedModel, free: Array) -> Array:
    """Step of the model's parameters and of the free law's, in widths of their bounds."""
    fit, space, solver = fitted_model.fit, fitted_model.model.space, bench.solver
    replay = Replay(fitted_model.model, bench.fit, bench.threads)
    unit, count = space.to_unit(fit.z) - space.to_unit(space.nominal), free.shape[2]
    prior = np.append(prior_precision(space, solver), np.full(count, solver.prior_spans**-2.0))
    linear = NormalEquations.build(
        residual=fit.residuals,
        state_jacobian=fit.slopes.state,
        parameter_jacobian=np.concatenate([fit.slopes.parameter, free], axis=2),
        weight=replay.weights(fit.residuals, fit.infeasible, solver.huber),
        delta=fit.delta,
        state_precision=bench.fit.prior.std**-2.0,
        prior=prior,
        prior_gradient=prior * np.append(unit, np.zeros(count)),
    )
    inside = np.append(space.to_unit(fit.z), np.full(count, 0.5))
    return linear.step(0.0, movable(inside, linear.slope))[0]


def _settled(bench: Bench, replay: Replay, point: Point, slopes: Slopes) -> Array:
    """Residuals after each window's state has moved to where its cost is lowest."""
    precision = bench.held_out.prior.std**-2.0
    weight = replay.weights(point.residuals, point.infeasible, bench.solver.huber)
    weighted = (slopes.state * weight[..., None]).transpose(0, 2, 1)
    gradient = (weighted @ point.residuals[..., None])[..., 0] + precision * point.delta
    step = -solved(weighted @ slopes.state + np.diag(precision), gradient[..., None])
    return point.residuals + (slopes.state @ step)[..., 0]
