"""Entries of a report that say how well something is known."""

import numpy as np
import pytest

from dr_lab.comparison.entries import _cv_percent, remaining
from dr_lab.diagnosis.evidence.score import ChannelScore, Score
from dr_lab.physics.parameter import Parameter
from tests.diagnosis_machines import evidence_settings

MASS = Parameter("mass", "kg", 1.0, 0.5, 2.0)


def test_logs_scatter_about_the_fitted_value() -> None:
    assert _cv_percent(MASS, np.array([0.9, 1.1]), 1.0, 0.05) == pytest.approx(100 * np.sqrt(0.02))


@pytest.mark.parametrize(
    ("values", "mean", "std"),
    [
        ([0.5, 0.5], 1.0, 0.05),  # both at the bound: they agree on nothing
        ([1.0, 2.0], 1.0, 0.05),
        ([0.9, 1.1], 0.001, 0.01),  # of an angle about its zero
        ([1.0], 1.0, 0.05),
    ],
)
def test_where_nothing_is_known_of_it_no_scatter_is_stated(values: list[float], mean: float, std: float) -> None:
    assert np.isnan(_cv_percent(MASS, np.array(values), mean, std))


@pytest.mark.parametrize("instrumental", [False, True])
def test_one_window_of_few_independent_residuals_is_no_coloured_noise(instrumental: bool) -> None:
    sums, count = np.array([292.0]), np.array([146.0])
    channel = ChannelScore(sums, count, 60.0, instrumental=instrumental)
    left = Score(2.0, {}, {}, {}, sums, count, np.zeros(1, np.intp), 0, {"hinge.position": channel})
    found = remaining(left, evidence_settings())
    assert found.status == "at_floor"  # two independent residuals may well leave as much
    assert found.coloured == instrumental
