"""Values of which the logs know the sum better than either."""

import numpy as np
import pytest

from dr_lab.comparison.trading import trading
from dr_lab.physics.context import ContextEstimate, ContextSpace
from dr_lab.physics.parameter import Parameter

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
