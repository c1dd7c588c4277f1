"""Friction that fades, against closed forms."""

import numpy as np
import pytest
from effect_machines import block, placed

from dr_lab.physics.law import History
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

MASS = 2.0  # kg, of the block
STEP = 0.002
RATE = 1.5  # 1/s


def slowed(dry: float, viscous: float, rate: float, begin: float, seconds: float = 0.5) -> tuple[Array, Array]:
    """Times since the log began, and speeds of a block that begins at 2 m/s at `begin` seconds."""
    model = block().with_effect(placed(block(), "friction_drift", "rail"))
    z, shape = np.array([[dry, viscous, rate]]), (1, 0, 1)
    history = History(np.array([begin]), np.zeros(shape), np.zeros(shape), np.zeros(shape))
    controls = np.zeros((1, round(seconds / STEP), 1))
    start, fast = np.zeros((1, 1, 1)), np.full((1, 1, 1), 2.0)
    rollout = Simulator(model, 1, threads=1).replay(z, start, fast, controls, controls[:, :1], history)
    return np.linspace(begin, begin + seconds, controls.shape[1] + 1), rollout.qvel[0, :, 0]


@pytest.mark.parametrize("begin", [0.0, 0.8])
def test_grease_brakes_by_what_is_left_of_it(begin: float) -> None:
    """m v' = −c e^(−r t) v."""
    time, speed = slowed(0.0, 3.0, RATE, begin)
    braked = 3.0 / RATE * (np.exp(-RATE * begin) - np.exp(-RATE * time))
    np.testing.assert_allclose(speed, 2.0 * np.exp(-braked / MASS), rtol=1e-5)


@pytest.mark.parametrize("begin", [0.0, 0.8])
def test_a_seal_brakes_by_what_is_left_of_it(begin: float) -> None:
    """m v' = −tau_c e^(−r t) while it slides."""
    time, speed = slowed(4.0, 0.0, RATE, begin)
    lost = 4.0 / RATE * (np.exp(-RATE * begin) - np.exp(-RATE * time)) / MASS
    np.testing.assert_allclose(speed, 2.0 - lost, rtol=0, atol=2e-5)


def test_a_seal_holds_until_it_is_warm() -> None:
    """5 N against 8 N e^(−r t): it lets go at r t = ln 1.6."""
    model = block().with_effect(placed(block(), "friction_drift", "rail"))
    controls, still = np.full((1, 500, 1), 5.0), np.zeros((1, 1, 1))
    rollout = Simulator(model, 1, threads=1).replay(
        np.array([[8.0, 0.0, RATE]]), still, still, controls, controls[:, :1]
    )
    begins = STEP * float(np.argmax(np.abs(rollout.qvel[0, :, 0]) > 1e-3))
    assert begins == pytest.approx(np.log(1.6) / RATE, abs=0.06)
    assert begins > np.log(1.6) / RATE


def test_what_does_not_fade_is_friction() -> None:
    time, speed = slowed(0.0, 3.0, 0.0, 0.3)
    np.testing.assert_allclose(speed, 2.0 * np.exp(-3.0 / MASS * (time - 0.3)), rtol=1e-5)


def test_bounds_follow_the_machine() -> None:
    dry, viscous, rate = placed(block(), "friction_drift", "rail").parameters
    assert (dry.unit, dry.high) == ("N", 10.0)
    assert (viscous.unit, viscous.high) == ("N·s/m", 10.0)  # twice 10 N at 2 m/s
    assert (rate.unit, rate.low) == ("1/s", 0.0)
