"""How well a fitted context is known, as reports state it and as effects of one parameter are judged by it."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from dr_lab.diagnosis.checks.step_error import step_shift
from dr_lab.diagnosis.evidence.bench import Bench, FittedModel
from dr_lab.diagnosis.evidence.compatible import known_of
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.physics.context import ContextEstimate
from dr_lab.trajectory import Array


class Known(NamedTuple):
    """How well a context is known.

    Attributes:
        estimate: with all that makes it uncertain.
        by_step: standard deviation that the time step alone gives each value, shape (n,).
    """

    estimate: ContextEstimate
    by_step: Array


def known(bench: Bench, fitted_model: FittedModel) -> Known:
    """A fitted context with all that makes it uncertain: noise, logs that disagree, and the time step.

    Values are those that make the model fit at its own step, for there it is used. At a step that hides nothing they
    would be s away (`step_shift`), in one direction of all parameters together: C + s sᵀ.
    """
    fit, space = fitted_model.fit, fitted_model.model.space
    found = known_of(bench, fitted_model)
    replay = Replay(fitted_model.model, bench.fit, bench.threads)
    away = space.span * step_shift(replay, fit, bench.solver, bench.threads)
    return Known(replace(found, covariance=found.covariance + np.outer(away, away)), np.abs(away))
