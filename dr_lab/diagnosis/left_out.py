"""What a fit says of its own windows as if it had not seen them: cross-validation by one linear step."""

import numpy as np

from dr_lab.diagnosis.blocks import Indices, blocks, logs
from dr_lab.diagnosis.fit import Fit, movable
from dr_lab.diagnosis.normal_equations import inverse_root
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.physics.context import ContextSpace
from dr_lab.trajectory import Array


def left_out(fit: Fit, space: ContextSpace, log: Indices, settings: EvidenceSettings) -> Array:
    """Residuals of each log at the context that all other logs prefer, shape (w, m); of few logs, of blocks of windows.

    Without the windows b the optimum moves by −(I + P − I_b)⁻¹ (g − g_b), g being the gradient of the whole cost, 0 at
    an optimum, and g_b that of the cost in these windows; their states follow. To first order these are the residuals
    of a fit to the others, so that they flatter a model with more parameters no more than held-out windows do.

    Source: Pregibon, Annals of Statistics 9 (1981) 705 (one-step deletion).

    Args:
        fit: the fit.
        space: of its context.
        log: index of each window's log, shape (w,).
        settings: number of logs that are few, and size of the blocks.
    """
    parts = logs(log)
    if len(parts) < settings.least_trusted:
        parts = blocks(log, settings.block, settings.least_blocks)
    information, gradient = fit.equations.window_information()
    moved = _moves(fit, space, information, gradient, parts)
    gain = np.linalg.solve(fit.equations.state, fit.equations.mixed)
    follow = -(gain @ moved[..., None])[..., 0]
    away = fit.slopes.parameter @ moved[..., None] + fit.slopes.state @ follow[..., None]
    return fit.residuals + away[..., 0]


def _moves(fit: Fit, space: ContextSpace, information: Array, gradient: Array, parts: list[Indices]) -> Array:
    """By how much the context moves where a window is left out with its part, in unit-cube parameters, shape (w, n)."""
    unit = space.to_unit(fit.z)
    whole = gradient.sum(0) + fit.equations.prior_gradient
    free = movable(unit, whole)
    total, moved = information.sum(0), np.zeros_like(gradient)
    for rows in parts:
        rest = (total - information[rows].sum(0))[np.ix_(free, free)]
        root = inverse_root(rest, fit.equations.prior[free])
        step = root @ (root.T @ (gradient[rows].sum(0) - whole)[free])
        moved[np.ix_(rows, free)] = np.clip(step, -unit[free], 1 - unit[free])
    return moved
