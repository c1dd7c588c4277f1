import numpy as np
import pytest
from effect_machines import block, placed

from dr_lab.trajectory import Array

STEP = 0.002
RATES = np.array([10.0, 130.0, 1000.0, 4000.0])  # units of the command per s


def limited(series: Array, inverse: Array) -> Array:
    """What the limits make of commands (w, s), shape (c, w, s)."""
    model = block().with_effect(placed(block(), "rate_limit", "drive"))
    return model.command(inverse[:, None], "drive", series[None])


def test_a_jump_becomes_a_ramp() -> None:
    series = np.repeat([-1.0, 2.0], [5, 40])[None]
    edges = STEP * np.arange(41)
    for row, rate in zip(limited(series, 1 / RATES)[:, 0], RATES, strict=True):
        there = 3.0 / rate  # s until the jump of 3 is made
        integral = np.where(edges < there, rate * edges**2 / 2, 3.0 * (edges - there / 2))
        np.testing.assert_allclose(row[5:], -1.0 + np.diff(integral) / STEP, rtol=1e-9, atol=1e-12)
        np.testing.assert_array_equal(row[:5], -1.0)


def test_slow_commands_and_absent_pass_unchanged() -> None:
    series = np.array([[0.0, 1.0, -2.0, 5.0]])
    np.testing.assert_array_equal(limited(series, np.zeros(1))[0], series)
    rise = 5e-4  # a step, where 0.02 may be made
    slow = np.linspace(0.0, 199 * rise, 200)[None]
    seen = limited(slow, 1 / RATES[:1])[0, 0]
    np.testing.assert_allclose(slow[0, 1:] - seen[1:], rise * (rise / RATES[0]) / (2 * STEP), rtol=1e-9)


def test_nothing_but_the_ramp_is_lost() -> None:
    """The area between a jump and its ramp is i Δ²/2, from absent on."""
    series = np.repeat([0.0, 1.5, -2.0], [5, 60, 60])[None]
    inverse = np.array([1e-6, 1e-4, 0.0013, 0.006])
    lost = STEP * (np.abs(np.diff(limited(series, np.array([0.0, *inverse])), axis=0))).sum(axis=(1, 2))
    np.testing.assert_allclose(np.cumsum(lost), inverse * (1.5**2 + 3.5**2) / 2, rtol=1e-9)


def test_fits_start_at_rates_within_the_commands() -> None:
    one = placed(block(), "rate_limit", "drive")
    assert one.parameters[0].high == pytest.approx(0.3 / 5.0)
    times = [start["rate_limit@drive.inverse_rate"] * 5.0 for start in one.starts]
    assert times == pytest.approx([0.004, 0.015, 0.06, 0.2])
    series = np.ones((1, 1, 3))
    assert block().with_effect(one).command(np.ones((1, 1)), "another", series) is series
