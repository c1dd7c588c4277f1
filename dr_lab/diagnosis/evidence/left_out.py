"""What a fit says of its own windows as if it had not seen them: cross-validation by one step."""

from dataclasses import replace

import numpy as np

from dr_lab.diagnosis.fit.fit import Fit, movable
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.normal_equations import inverse_root
from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import polished
from dr_lab.diagnosis.settings import EvidenceSettings, SolverSettings
from dr_lab.diagnosis.windows.blocks import Indices, blocks, logs
from dr_lab.trajectory import Array


def left_out(replay: Replay, fit: Fit, solver: SolverSettings, settings: EvidenceSettings) -> Point:
    """Residuals of each log at the context that all other logs prefer; of few logs, of blocks of windows.

    Without the windows b the optimum moves by −(I + P − I_b)⁻¹ (g − g_b), g being the gradient of the whole cost, 0 at
    an optimum, and g_b that of the cost in these windows; their states follow. To first order these are the residuals
    of a fit to the others, so that they flatter a model with more parameters no more than held-out windows do.

    Where that foretells squares `settings.astray` times as large as the fit's, the step leads beyond where slopes hold:
    a law bends, and nothing holds the step back. Then a damped step that lowers the cost of the others takes its place,
    and the windows are simulated.

    Source: Pregibon, Annals of Statistics 9 (1981) 705 (one-step deletion).

    Args:
        replay: the windows that were fitted.
        fit: the fit.
        solver: settings of fits.
        settings: number of logs that are few, size of the blocks, and which step is astray.

    Returns:
        The fit's context, with residuals, shape (w, m), states and windows that diverge as foretold.
    """
    log = replay.windows.log
    parts = parts_of(log, settings)
    delta, residuals = _linear(replay, fit, parts)
    found = Point(fit.z, delta, residuals, np.inf, fit.infeasible.copy())
    for rows in parts:
        seen, foretold = (float(np.square(r[rows]).sum()) for r in (fit.residuals, residuals))
        if len(rows) < len(log) and foretold > settings.astray * seen:
            own = _refitted(replay, fit, rows, solver)
            found.delta[rows], found.residuals[rows] = own.delta, own.residuals
            found.infeasible[rows] |= own.infeasible
    return found


def parts_of(log: Indices, settings: EvidenceSettings) -> list[Indices]:
    """Parts of windows that are left out together: logs, or where they are few blocks of windows.

    Args:
        log: index of each window's log, shape (w,).
        settings: number of logs that are few, and size of the blocks.
    """
    found = logs(log)
    return found if len(found) >= settings.least_trusted else blocks(log, settings.block, settings.least_blocks)


def _linear(replay: Replay, fit: Fit, parts: list[Indices]) -> tuple[Array, Array]:
    """States (w, s) and residuals (w, m) that follow where each window is left out with its part.

    Slopes are by parameters in the unit cube.
    """
    unit = replay.model.space.to_unit(fit.z)
    moved = np.zeros((len(fit.delta), len(unit)))
    for move, rows in zip(_moves(unit, fit, parts), parts, strict=True):
        moved[rows] = move
    follow = -(fit.equations.reduced.gain @ moved[..., None])[..., 0]
    away = fit.slopes.parameter @ moved[..., None] + fit.slopes.state @ follow[..., None]
    return fit.delta + follow, fit.residuals + away[..., 0]


def _moves(unit: Array, fit: Fit, parts: list[Indices]) -> Array:
    """By how much the context moves without each part, in unit-cube parameters, shape (parts, n)."""
    information, gradient = fit.equations.window_information()
    whole = gradient.sum(0) + fit.equations.prior_gradient
    free = movable(unit, whole)
    total, moves = information.sum(0), np.zeros((len(parts), len(unit)))
    for move, rows in zip(moves, parts, strict=True):
        rest = (total - information[rows].sum(0))[np.ix_(free, free)]
        root = inverse_root(rest, fit.equations.prior[free])
        step = root @ (root.T @ (gradient[rows].sum(0) - whole)[free])
        move[free] = np.clip(step, -unit[free], 1 - unit[free])
    return moves


def _refitted(replay: Replay, fit: Fit, rows: Indices, solver: SolverSettings) -> Point:
    """Windows at the context that one damped step of a fit to all others leads to, their states fitted there."""
    others = np.setdiff1d(np.arange(len(replay.windows)), rows)
    fitter = Fitter(replay.part(others), solver)
    rest = fitter.run(fit.z, fit.delta[others], fit.slopes.pick(others), iterations=1)
    part = replay.part(rows)
    residuals, infeasible = part.residuals(rest.z[None], fit.delta[None, rows])
    there = Point(rest.z, fit.delta[rows], residuals[0], np.inf, infeasible[0])
    states = polished(part, solver, there, fit.slopes.state[rows], ~there.infeasible)
    return replace(there, delta=states.delta, residuals=states.residuals, infeasible=states.infeasible)
