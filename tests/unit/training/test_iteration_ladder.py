"""The iterations of a learner, told one after the other."""

import numpy as np

from dr_lab.recorders.training import Spread
from dr_lab.training.ladder import declines, ladder

NAN = float("nan")
SPREAD = Spread("mass", "kg", np.arange(4), np.array([1.0, 1.0, 1.5, 1.8]), np.array([0.4, 0.4, 0.2, 0.1]))


def row(iteration: int, **figures: float) -> dict[str, float]:
    return {"iteration": float(iteration), "frames": 64.0 * iteration, **figures}


def test_each_iteration_has_its_distribution_and_the_beginning_comes_first() -> None:
    compared = {"discrepancy": 8.0, "discrepancy_of_mean": 2.0, "divergence": 1.0, "target_steps": 30.0}
    history = [row(1), row(2, **compared), row(3, **{**compared, "discrepancy": NAN, "discrepancy_of_mean": 0.5})]
    start, first, second = ladder(history, [SPREAD])
    assert (start.iteration, start.frames, start.discrepancy, start.target_steps) == (0, 0, None, 0)
    assert (start.context["mass"].mean, start.context["mass"].std) == (1.0, 0.4)
    assert (first.iteration, first.frames, first.discrepancy, first.divergence, first.target_steps) == (
        2,
        128,
        8,
        1,
        30,
    )
    assert (first.context["mass"].mean, second.context["mass"].mean) == (1.5, 1.8)
    (decline,) = declines([start, first, second])
    assert decline.iteration.tolist() == [2, 3]
    np.testing.assert_array_equal(list(decline.values.values()), [[8.0, NAN], [2.0, 0.5]])


def test_where_nothing_is_compared_there_is_no_ladder() -> None:
    assert ladder([row(1), row(2, divergence=0.1)], [SPREAD]) == ()
    assert declines(()) == []
