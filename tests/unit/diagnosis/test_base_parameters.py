import numpy as np
import pytest

from dr_lab.diagnosis.fit.base_parameters import BaseParameters, base_parameters
from dr_lab.diagnosis.fit.normal_equations import NormalEquations
from dr_lab.trajectory import Array

NAMES = ("a", "b", "c", "d", "friction")


def found(columns: Array, prior: Array | None = None) -> BaseParameters:
    """Of the first four parameters, where residuals fall by `columns` (m, 5) for each unit of a parameter."""
    window = columns[None]
    prior = np.ones(5) if prior is None else prior
    equations = NormalEquations.build(
        residual=np.zeros(window.shape[:2]),
        state_jacobian=np.zeros((*window.shape[:2], 1)),
        parameter_jacobian=window,
        weight=np.ones(window.shape[:2]),
        delta=np.zeros((1, 1)),
        state_precision=np.ones(1),
        prior=prior,
        prior_gradient=np.zeros(5),
    )
    return base_parameters(equations, NAMES, np.arange(4))


def outputs(*directions: Array, size: float = 100.0) -> Array:
    return size * np.array(directions)


def test_combinations_that_outputs_follow_are_counted_and_told() -> None:
    mass, moment = np.array([0.8, 0.6, 0, 0, 0]), np.array([0, 0, 1.0, 0, 0])
    base = found(outputs(mass, moment / 10))
    assert (base.count, base.rank, base.known) == (4, 2, 2)
    assert base.condition == pytest.approx(10.0)
    assert base.chosen == ("a", "c")  # a tells more of the sum than b
    assert base.held == ("a", "b", "d")
    assert base.best[0] == pytest.approx({"a": 0.8, "b": 0.6})
    assert base.worst == ()


def test_what_is_seen_less_well_than_the_prior_knows_is_not_known() -> None:
    base = found(np.array([[100.0, 0, 0, 0, 0], [0, 1.0, 0, 0, 0]]))
    assert (base.rank, base.known) == (2, 1)
    assert base.held == ("b", "c", "d")
    assert base.worst == (pytest.approx({"b": 1.0}),)


def test_a_tighter_prior_leaves_less_to_the_logs() -> None:
    columns = np.array([[10.0, 0, 0, 0, 0]])
    assert found(columns).known == 1
    assert found(columns, np.array([400.0, 1, 1, 1, 1])).known == 0


def test_what_a_free_friction_takes_the_place_of_is_not_known() -> None:
    together = np.array([[100.0, 0, 0, 0, 100.0]])
    assert found(together).known == 0
    apart = np.array([[100.0, 0, 0, 0, 100.0], [0, 0, 0, 0, 100.0]])
    assert found(apart).known == 1


def test_what_finite_differences_cannot_show_is_not_known() -> None:
    base = found(np.array([[1e6, 0, 0, 0, 0], [0, 3.0, 0, 0, 0]]))  # 1e-11 of the information, though 9 of the prior's
    assert (base.rank, base.known) == (1, 1)
    assert base.chosen == ("a",)
