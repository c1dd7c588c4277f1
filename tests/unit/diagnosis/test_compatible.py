import numpy as np
import pytest

from dr_lab.diagnosis.evidence.compatible import chance, chance_within
from dr_lab.physics.context import ContextEstimate, ContextSpace
from dr_lab.physics.parameter import Parameter

SPACE = ContextSpace(tuple(Parameter(name, "1", 0.0, -1.0, 1.0) for name in "abc"))


def known(mean: list[float], covariance: np.ndarray) -> ContextEstimate:
    return ContextEstimate(SPACE, np.array(mean), covariance)


def test_one_parameter_is_judged_by_its_standard_deviations() -> None:
    found = known([0.3, 0.2, 0.0], np.diag([0.01, 1.0, 1.0]))
    assert chance(found, {"a": 0.0}) == pytest.approx(0.0026998, rel=1e-4)  # three of them, both sides
    assert chance(found, {"a": 0.3}) == 1


def test_several_are_judged_together() -> None:
    """χ² with two degrees of freedom exceeds 9 in exp(−4.5) of all cases."""
    found = known([0.3, 5.0, 0.0], np.diag([0.01, 1e-6, 1.0]))
    assert chance(found, {"a": 0.0, "c": 0.0}) == pytest.approx(np.exp(-4.5))


def test_parameters_that_can_replace_one_another_are_certain_together_alone() -> None:
    """Each is known to ±1, their sum of 0.1 to ±0.01."""
    apart, together = np.array([1.0, -1.0, 0.0]) / np.sqrt(2), np.array([1.0, 1.0, 0.0]) / np.sqrt(2)
    covariance = 2 * np.outer(apart, apart) + 5e-5 * np.outer(together, together) + np.diag([0.0, 0.0, 1.0])
    found = known([0.05, 0.05, 0.0], covariance)
    assert chance(found, {"a": 0.0}) > 0.9
    assert chance(found, {"a": 0.0, "b": 0.0}) < 1e-20


def test_parameters_of_different_size_are_judged_alike() -> None:
    one = known([0.3, 0.2, 0.0], np.array([[0.01, 0.004, 0], [0.004, 0.01, 0], [0, 0, 1.0]]))
    scale = np.diag([1e-9, 1e6, 1.0])
    other = known([0.3e-9, 0.2e6, 0.0], scale @ one.covariance @ scale)
    both = {"a": 0.0, "b": 0.0}
    assert chance(other, both) == pytest.approx(chance(one, both))


def test_what_shapes_an_effect_does_not_hide_it() -> None:
    """The size a, known to ±0.1 where the shape b is given, trades with b one to one."""
    trade = np.array([1.0, 1.0, 0.0])
    found = known([0.3, 0.5, 0.0], np.outer(trade, trade) + np.diag([0.01, 0.0, 1.0]))
    assert chance(found, {"a": 0.0}) > 0.7
    assert chance(found, {"a": 0.0}, given=["b"]) == pytest.approx(0.0026998, rel=1e-4)


def test_the_scatter_between_few_logs_is_badly_known() -> None:
    """Student's t with two degrees of freedom exceeds 9.925 in one case of two hundred, to either side."""
    found = known([0.9925, 0.0, 0.0], np.diag([0.01, 1.0, 1.0]))
    assert chance(found, {"a": 0.0}, freedom=2) == pytest.approx(0.01, rel=1e-3)


def test_within_far_bounds_the_test_is_walds() -> None:
    found = known([0.03, 0.02, 0.0], 1e-4 * np.array([[4.0, 1.5, 0], [1.5, 2.0, 0.4], [0, 0.4, 1.0]]))
    for values in ({"a": 0.0}, {"a": 0.0, "b": 0.0}):
        assert chance_within(found, values) == pytest.approx(chance(found, values), rel=1e-6)


def test_what_trades_with_a_parameter_does_so_as_far_as_it_may() -> None:
    """The sum of a and b is known to ±0.01, either to ±1; b lies at its upper end and cannot make up for less of a."""
    apart, together = np.array([1.0, -1.0, 0.0]) / np.sqrt(2), np.array([1.0, 1.0, 0.0]) / np.sqrt(2)
    covariance = 2 * np.outer(apart, apart) + 5e-5 * np.outer(together, together) + np.diag([0.0, 0.0, 1.0])
    low, high = known([0.3, 1.0, 0.0], covariance), known([0.3, -0.99, 0.0], covariance)
    assert chance(low, {"a": 0.0}) > 0.7
    assert chance_within(low, {"a": 0.0}) < 1e-100  # b would have to be 1.3, beyond its end
    assert chance_within(high, {"a": 0.0}) == pytest.approx(chance(high, {"a": 0.0}), rel=1e-3)
