"""Plots against time: two numbers on every axis, a legend where nothing is hidden, lines that break where they must."""

import dataclasses

import numpy as np
import pytest
import rerun.blueprint as rrb

from dr_lab.recorders.free_corner import free_corner
from dr_lab.recorders.look import Look
from dr_lab.recorders.numbered_axis import numbered_axis, reach
from dr_lab.recorders.overlay import Overlay
from dr_lab.recorders.title_numbers import first_last
from dr_lab.trajectory import Signal

HEIGHT = 200.0  # px: ten numbers would be 20 px apart, which is too near
TIME = np.linspace(0.0, 1.0, 101)


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [(-6.0, 6.0, (-6.0, 10.0)), (0.2, 9.8, (0.0, 10.0)), (-4.0, 5.5, (-4.0, 10.0)), (-0.06, 0.03, (-0.06, 0.03))],
)
def test_an_axis_reaches_to_the_second_number(low: float, high: float, expected: tuple[float, float]) -> None:
    assert reach(low, high, HEIGHT) == pytest.approx(expected)


@pytest.mark.parametrize("seed", range(20))
def test_every_axis_shows_two_numbers_and_its_values(seed: int) -> None:
    rng = np.random.default_rng(seed)
    low = float(rng.normal(scale=10.0 ** rng.integers(-3, 4)))
    high = low + float(10.0 ** rng.uniform(-3, 4))
    bottom, top = reach(low, high, HEIGHT)
    step = 10.0 ** np.ceil(np.log10((high - low) * 22.0 / HEIGHT))
    assert np.floor(top / step + 1e-9) - np.ceil(bottom / step - 1e-9) >= 1
    assert bottom <= low < high <= top
    assert top - bottom <= high - low + 2 * step


def test_what_is_constant_or_unknown_is_left_to_the_viewer() -> None:
    assert numbered_axis([np.zeros(3)], rows=1) is None
    assert numbered_axis([np.full(3, np.nan)], rows=1) is None
    assert numbered_axis([np.array([-6.0, np.nan, 6.0])], rows=4) is not None


def test_a_legend_stands_where_no_curve_is() -> None:
    assert free_corner([(TIME, TIME)]) == rrb.Corner2D.LeftTop
    assert free_corner([(TIME, -TIME)]) == rrb.Corner2D.RightTop
    assert free_corner([(TIME, np.stack([TIME, 1.0 - 0.3 * TIME], axis=1))]) == rrb.Corner2D.RightBottom
    assert free_corner([]) == free_corner([(TIME, np.full(101, np.nan))]) == rrb.Corner2D.LeftTop


def test_lines_break_where_the_simulation_begins_anew(overlay: Overlay) -> None:
    starts = np.array([-1.0, 0.0, 0.5, 0.505, 2.0])
    time, value = dataclasses.replace(overlay, starts=starts).broken(TIME, np.stack([TIME, TIME], axis=1))
    gaps = np.isnan(value).all(axis=1)
    np.testing.assert_allclose(time[gaps], [0.495, 0.505])  # before 0.5, and before the first sample from 0.505 on
    np.testing.assert_array_equal(value[~gaps, 0], TIME)
    assert (np.diff(time) > 0.0).all()


def test_the_length_is_that_of_most_windows(overlay: Overlay) -> None:
    assert overlay.length() is None
    assert dataclasses.replace(overlay, starts=np.array([0.0, 0.3, 0.6, 2.0])).length() == pytest.approx(0.3)


def test_commands_are_told_apart(look: Look) -> None:
    colours = [look.command(index) for index in range(4)]
    assert len({*colours}) == 4
    assert colours[0] == look.colour("command")
    assert not {look.colour("before"), look.colour("after")} & {*colours}


def test_a_title_tells_first_and_last() -> None:
    assert first_last(np.array([np.nan, 1.0, 5.0, 2.5, np.nan])) == ": 1 → 2.5"
    assert first_last(np.array([np.nan, 3.0])) == ": 3"
    assert first_last(np.array([np.nan])) == ""


def test_what_is_left_of_an_orientation_is_a_turn(overlay: Overlay) -> None:
    turned = Signal("sensor.box", "1", TIME, np.tile([1.0, 0.0, 0.0, 0.0], (101, 1)))
    more = dataclasses.replace(
        overlay, measured={**overlay.measured, "sensor.box": turned}, noise={**overlay.noise, "sensor.box": 0.01}
    )
    assert (more.residual_unit("sensor.box"), more.residual_std("sensor.box")) == ("rad", 0.02)
    assert more.residual_std("arm.position") == overlay.noise["arm.position"]
