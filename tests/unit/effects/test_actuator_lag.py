import numpy as np
import pytest
from effect_machines import CONF, block, placed
from omegaconf import OmegaConf

from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

STEP = 0.002
TAUS = np.array([[0.0], [1e-9], [0.0005], [0.004], [0.012]])


def lagged(series: Array) -> Array:
    """What the lag makes of commands (w, s) under each time constant, shape (c, w, s)."""
    return block().with_effect(placed(block(), "actuator_lag", "drive")).command(TAUS, "drive", series[None])


def test_a_jump_is_followed_exponentially() -> None:
    """Averages of 1 − exp(−t/tau) over the steps; windows of their own, some of them at rest."""
    series = np.stack([np.repeat([0.0, 3.0], [10, 40]), np.full(50, 2.0)])
    seen, edges = lagged(series), STEP * np.arange(41)
    for row, (tau,) in zip(seen[2:], TAUS[2:], strict=True):
        integral = edges + tau * np.exp(-edges / tau)
        np.testing.assert_allclose(row[0, 10:], 3.0 * np.diff(integral) / STEP, rtol=1e-9)
    np.testing.assert_array_equal(seen[0], series)
    np.testing.assert_allclose(seen[1], series, atol=3e-6)
    np.testing.assert_array_equal(seen[:, :, :10], np.broadcast_to(series[:, :10], (5, 2, 10)))
    np.testing.assert_allclose(seen[:, 1], 2.0, rtol=1e-15)


def test_commands_of_other_actuators_are_left_alone() -> None:
    model, series = block().with_effect(placed(block(), "actuator_lag", "drive")), np.ones((1, 1, 5))
    assert model.command(TAUS, "another", series) is series


def test_the_machine_loses_the_impulse_of_the_lag() -> None:
    model, count = block().with_effect(placed(block(), "actuator_lag", "drive")), len(TAUS)
    rest, past = np.zeros((count, 1, 1)), np.zeros((1, 30, 1))
    rollout = Simulator(model, count, threads=1).replay(TAUS, rest, rest, np.full((1, 100, 1), 4.0), past)
    (tau,), time = TAUS.T, 0.2
    lost = np.array([t * -np.expm1(-time / t) if t else 0.0 for t in tau])
    np.testing.assert_allclose(rollout.qvel[:, -1, 0], 4.0 / 2.0 * (time - lost), rtol=1e-9)


def test_the_past_is_long_enough_for_the_longest() -> None:
    (parameter,) = placed(block(), "actuator_lag", "drive").parameters
    past = OmegaConf.load(CONF / "comparison" / "default.yaml").windows.past
    assert parameter.high == pytest.approx(past / 5)
