"""What the time step does to residuals, and to a context that is fitted to them."""

import numpy as np

from dr_lab.diagnosis.checks.numerical_floor import in_parts
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.normal_equations import NormalEquations
from dr_lab.diagnosis.fit.point import Mask, Point
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.settings import SolverSettings
from dr_lab.diagnosis.windows.finer import finer
from dr_lab.trajectory import Array

_PARTS = 2


def step_error(replay: Replay, point: Point, threads: int | None) -> tuple[Array, Mask]:
    """Error of the step h in a point's residuals (w, m); and which windows diverge at half the step (w,).

    A force that jumps, as dry friction does, leaves an error that falls as h does. So two halves tell all of it:
    2 (r(h) − r(h/2)), which is too much where it falls faster.

    Source: Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, 1993, section II.4 (extrapolation).
    """
    fine = Replay(in_parts(replay.model, _PARTS), finer(replay.windows, _PARTS), threads)
    fine.begin_like(replay)
    residuals, diverged = fine.residuals(point.z[None], point.delta[None])
    return _PARTS / (_PARTS - 1) * (point.residuals - residuals[0]), diverged[0]


def step_shift(replay: Replay, fit: Fit, settings: SolverSettings, threads: int | None) -> Array:
    """By how much a context fitted without a step's error would differ, to first order, in the unit cube, shape (n,).

    (I + P)⁻¹ Σ_w g_w(e): the linear step that leads from the fit to where residuals without their error e
    (`step_error`) are least, the windows' states eliminated. Windows that diverge take no part.
    """
    error, diverged = step_error(replay, fit, threads)
    used = ~(diverged | fit.infeasible)
    weight = replay.weights(fit.residuals, fit.infeasible, settings.huber) * used[:, None]
    equations = NormalEquations.build(
        residual=np.where(used[:, None], error, 0.0),
        state_jacobian=fit.slopes.state,
        parameter_jacobian=fit.slopes.parameter,
        weight=weight,
        delta=np.zeros_like(fit.delta),
        state_precision=replay.windows.prior.std**-2.0,
        prior=fit.equations.prior,
        prior_gradient=np.zeros_like(fit.equations.prior),
    )
    move, _ = equations.step(0.0, np.ones(len(fit.z), bool))
    return -move
