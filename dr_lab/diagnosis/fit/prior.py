"""The weak prior of a fit's parameters around their nominal values."""

import numpy as np

from dr_lab.diagnosis.settings import SolverSettings
from dr_lab.physics.context import ContextSpace
from dr_lab.trajectory import Array


def prior_precision(space: ContextSpace, settings: SolverSettings) -> Array:
    """Its precision by parameter, in unit-cube parameters, shape (n,)."""
    return np.array([settings.prior_spans if p.prior is None else p.prior for p in space.parameters]) ** -2.0
