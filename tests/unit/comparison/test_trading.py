"""Values of which the logs know the sum better than either."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from effect_machines import block, placed

from dr_lab.comparison.trading import together, trading
from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.physics.context import ContextEstimate, ContextSpace
from dr_lab.physics.model import Model
from dr_lab.physics.parameter import Parameter
from dr_lab.reports.gap_entries import TOGETHER

MEAN = "asymmetric_friction@x.mean"


def estimate(other: str, unit: str, correlation: float) -> ContextEstimate:
    """57.2 ± 6 N and 11.3 ± 6 N or another unit, correlated."""
    space = ContextSpace((Parameter(MEAN, "N", 0.0, 0.0, 100.0), Parameter(other, unit, 0.0, 0.0, 100.0)))
    covariance = 36.0 * np.array([[1.0, correlation], [correlation, 1.0]])
    return ContextEstimate(space, np.array([57.2, 11.3]), covariance)


@pytest.mark.parametrize(
    ("correlation", "told"), [(-0.999, "their sum, 68.50 ± 0.27 N"), (0.999, "their difference, 45.90 ± 0.27 N")]
)
def test_two_frictions_that_share_one_force_are_told(correlation: float, told: str) -> None:
    """The variance of the sum is 2 · 36 · (1 − 0.999) N²."""
    (note,) = trading(estimate("smooth_friction@x.torque", "N", correlation))
    assert note.message.startswith(f"{MEAN} and smooth_friction@x.torque trade: the logs know {told}, far better")


def test_what_is_known_or_of_other_kinds_does_not_trade() -> None:
    assert trading(estimate("smooth_friction@x.torque", "N", -0.9)) == []
    assert trading(estimate("smooth_friction@x.creep", "m/s", -0.999)) == []


def test_friction_that_differs_by_direction_is_told_as_friction_and_an_offset() -> None:
    """6.5 N that differ by 0.55 of themselves are 6.5 N both ways and a weight of 3.575 N."""
    model = block()
    model = model.with_effect(placed(model, "coulomb_friction", "rail"))
    assert together(at(model, {"coulomb_friction@rail.torque": 6.5})) == []
    model = block().with_effect(placed(block(), "asymmetric_friction", "rail"))
    label = model.effects[-1].label
    (note,) = together(at(model, {f"{label}.mean": 6.5, f"{label}.asymmetry": 0.55}))
    assert note.kind == TOGETHER
    assert note.message == (
        "No log tells `asymmetric_friction@rail` from `coulomb_friction@rail` (6.5 N) and `constant_offset@rail` "
        "(-3.58 N) together."
    )


def at(model: Model, values: dict[str, float]) -> FittedModel:
    """A fit that ended at some values."""
    fit = cast(Any, SimpleNamespace(z=model.space.vector(values)))
    nothing = cast(Any, None)
    return FittedModel(model, fit, nothing, nothing)
