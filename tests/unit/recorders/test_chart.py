import numpy as np
import pytest
import rerun as rr

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import Axis, Canvas, Chart, decade_axis, linear_axis
from dr_lab.recorders.scatter import bin_means


@pytest.mark.parametrize(
    ("low", "high", "labels"),
    [
        (0.0, 1.0, ["0", "0.2", "0.4", "0.6", "0.8", "1"]),
        (-0.013, 0.013, ["-0.01", "-0.005", "0", "0.005", "0.01"]),
        (-25.0, 100.0, ["-20", "0", "20", "40", "60", "80", "100"]),
        (3.0, 3.0, ["2", "2.5", "3", "3.5", "4"]),
        (3.0, 3.0 + 1e-12, ["2", "2.5", "3", "3.5", "4"]),
        (1000.09, 1000.41, ["1000.1", "1000.15", "1000.2", "1000.25", "1000.3", "1000.35", "1000.4"]),
        (-12345.0, -12342.0, ["-12345", "-12344.5", "-12344", "-12343.5", "-12343", "-12342.5", "-12342"]),
    ],
)
def test_ticks_are_round_and_inside(low: float, high: float, labels: list[str]) -> None:
    axis = linear_axis("x", low, high)
    assert [label for _, label in axis.ticks] == labels
    assert all(axis.low <= value <= axis.high for value, _ in axis.ticks)


def test_decades_are_labelled_with_their_values() -> None:
    assert decade_axis("χ²", 1.0, 5000.0).ticks == [(0.0, "1"), (1.0, "10"), (2.0, "100"), (3.0, "1000")]
    assert [label for _, label in decade_axis("χ²", 0.9, 12.0).ticks] == ["1", "2", "5", "10"]


def test_larger_values_lie_higher_and_outliers_at_the_edge() -> None:
    canvas = Canvas(width=100.0, height=50.0, left=0.0, right=0.0, top=0.0, bottom=0.0)
    chart = Chart(Branch(rr.RecordingStream("dr_lab_test")), canvas, Axis("", -1.0, 1.0, []), Axis("", 0.0, 10.0, []))
    placed = chart.place([-1.0, 0.0, 1.0, 7.0], [0.0, 5.0, 10.0, -3.0])
    np.testing.assert_allclose(placed, [[0, 50], [50, 25], [100, 0], [100, 50]])


def test_means_recover_a_step_at_zero_velocity() -> None:
    random = np.random.default_rng(1)
    velocity = random.uniform(-2.0, 2.0, 6000)
    residual = 0.3 * np.sign(velocity) + random.normal(0.0, 0.1, 6000)
    residual[::7] = np.nan
    x, y = bin_means(velocity, residual, 20)
    assert len(x) == 20
    assert len(bin_means(velocity[:70], residual[:70], 20)[0]) == 7  # √60 finite ones
    assert (np.diff(x) > 0).all()
    assert y[x > 0.1] == pytest.approx(0.3, abs=0.03)
    assert y[x < -0.1] == pytest.approx(-0.3, abs=0.03)


def test_no_finite_pair_has_no_means() -> None:
    assert [len(part) for part in bin_means(np.array([np.nan]), np.array([1.0]), 4)] == [0, 0]
