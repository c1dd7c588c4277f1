from pathlib import Path

import numpy as np
import pytest
import rerun as rr
import rerun.blueprint as rrb
from recorder_samples import read_recording

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import Axis, Canvas, Chart, decade_axis, linear_axis
from dr_lab.recorders.grids import log_grid
from dr_lab.recorders.heat_map import CANVAS
from dr_lab.recorders.look import Look
from dr_lab.recorders.recording import recording_file
from dr_lab.recorders.scatter import bin_means
from dr_lab.recorders.training import ContextAxis, Grid


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


def test_a_line_is_drawn_as_far_as_it_is_inside() -> None:
    canvas = Canvas(width=100.0, height=50.0, left=0.0, right=0.0, top=0.0, bottom=0.0)
    chart = Chart(Branch(rr.RecordingStream("dr_lab_test")), canvas, Axis("", 0.0, 10.0, []), Axis("", 0.0, 1.0, []))
    x = np.arange(10.0)
    first, second = chart.within(x, np.array([0.5, 0.5, 2.0, 2.0, 0.0, 1.0, 0.0, -1.0, 0.5, -1.0]))
    np.testing.assert_allclose(first, [[0, 25], [10, 25]])
    np.testing.assert_allclose(second, [[40, 50], [50, 0], [60, 50]])  # a single point is no line
    assert chart.within(x, np.full(10, 3.0)) == []


def test_labels_below_an_axis_have_room(tmp_path: Path) -> None:
    canvas = Canvas(width=130.0, height=50.0, left=0.0, right=0.0, top=0.0, bottom=0.0)
    with recording_file(tmp_path / "a.rrd", "dr_lab_test", "test", rrb.Blueprint()) as root:
        for name, high in (("short", 10.0), ("long", 0.0005)):
            chart = Chart(root / name, canvas, linear_axis("", 0.0, high, 8), linear_axis("", 0.0, 1.0))
            chart.frame((255, 255, 255, 255), (255, 255, 255, 255))
    found = read_recording(tmp_path / "a.rrd")
    short, long = (found[f"/{name}/ticks_x"]["Points2D:labels"][-1] for name in ("short", "long"))
    assert short == ["0", "1", "2", "3", "4", "5", "6", "7", "8", "9", "10"]
    assert long == ["0", "0.0001", "0.0002", "0.0003", "0.0004", "0.0005"]
    assert len(found["/long/grid"]["LineStrips2D:strips"][-1]) == 11 + 6 + 1  # all ticks have their line


def test_contexts_without_a_return_are_hatched(tmp_path: Path, look: Look) -> None:
    axis = ContextAxis("size", "m", np.array([0.0, 1.0, 2.0, 3.0]))
    with recording_file(tmp_path / "a.rrd", "dr_lab_test", "test", rrb.Blueprint()) as root:
        log_grid(
            root / "grid", Grid("run", [axis], np.array([np.nan, np.nan, 5.0, 6.0]), np.zeros(4), "episodes"), look
        )
    strips = read_recording(tmp_path / "a.rrd")["/grid/infeasible"]["LineStrips2D:strips"][-1]
    across = np.concatenate([np.array(strip)[:, 0] for strip in strips])
    assert across.min() == pytest.approx(0.0)
    assert across.max() == pytest.approx(CANVAS.width / 2)  # two of four cells


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
