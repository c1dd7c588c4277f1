import numpy as np
import pytest
from diagnosis_machines import solver_settings

from dr_lab.diagnosis.fit.pace import Pace


def pace_of(*gains: float) -> Pace:
    pace = Pace(solver_settings(crawl=3, crawl_swing=5.0, pace=4), 100.0)
    for gain in gains:
        pace.add(100.0, 100.0 - gain)
    return pace


@pytest.mark.parametrize(
    ("gains", "expected"),
    [
        ([0.1, 0.2], False),  # too few
        ([9.0, 0.1, 0.2, 0.1], True),
        ([0.1, 0.2, 0.8], False),  # they gain enough
        ([-1.0, 0.2, -2.0], True),
        ([-120.0, 0.2, -121.0], False),  # a bend
        ([-np.inf, 0.2, -2.0], False),
    ],
)
def test_a_descent_crawls_that_gains_little_and_meets_no_bend(gains: list[float], *, expected: bool) -> None:
    assert pace_of(*gains).crawls(1.0) is expected


@pytest.mark.parametrize(
    ("gains", "expected"),
    [([1.0, 1.0, 1.0], False), ([9.0, 1.0, 1.0, -5.0, 2.0], True), ([9.0, 1.0, 1.0, -5.0, 3.0], False)],
)
def test_a_goal_is_too_far_for_the_pace_of_the_last_steps(gains: list[float], *, expected: bool) -> None:
    assert pace_of(*gains).too_slow(12.0, 10) is expected


def test_the_costs_are_the_lowest_after_each_step() -> None:
    pace = pace_of()
    for cost, after in ((100.0, 60.0), (60.0, 80.0), (50.0, 40.0)):  # a new weighting of residuals may lower it, too
        pace.add(cost, after)
    assert pace.costs == [100.0, 60.0, 60.0, 40.0]
