"""Friction by a sigmoid of the velocity, against closed forms."""

import numpy as np
import pytest
from effect_machines import block, placed, scales_of
from scipy.integrate import solve_ivp

from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

MASS = 2.0  # kg, of the block
STEP = 0.002
TORQUE = 8.0  # N


def effect() -> PlacedEffect:
    return placed(block(), "smooth_friction", "rail", scales_of(block(), position=10.0, speed=20.0))


def speeds(creep: float, command: float | Array, start: float = 0.0, torque: float = TORQUE) -> Array:
    """Speeds of the block, pushed by `command` in N and begun at a speed in m/s."""
    model, place = block().with_effect(effect()), np.zeros((1, 1, 1))
    controls = (np.zeros(250) + command)[None, :, None]
    rollout = Simulator(model, 1, threads=1).replay(
        np.array([[torque, creep]]), place, place + start, controls, controls[:, :1], None
    )
    return rollout.qvel[0, :, 0]


def test_a_block_that_is_left_alone_stops_as_the_equation_says() -> None:
    """d(sinh(v/c))/dt = −(tau_c / (m c)) sinh(v/c)."""
    creep, time = 1.0, STEP * np.arange(251)
    expected = creep * np.arcsinh(np.sinh(2.0 / creep) * np.exp(-TORQUE / (MASS * creep) * time))
    np.testing.assert_allclose(speeds(creep, 0.0, start=2.0), expected, rtol=0, atol=2e-4)


@pytest.mark.parametrize("load", [0.4, 2.4, 5.0])
@pytest.mark.parametrize("creep", [0.02, 1e-3, 1e-4, 1e-5])
def test_under_a_load_below_its_torque_it_creeps_however_stiff_that_is_for_the_step(creep: float, load: float) -> None:
    """The least creep is a thousandth of the speed that the torque gives or takes in a step."""
    expected = creep * np.arctanh(load / TORQUE)
    np.testing.assert_allclose(speeds(creep, load)[-100:], expected, rtol=1e-3, atol=2e-3 * STEP * TORQUE / MASS)


def test_for_little_creep_it_slides_as_coulomb_friction() -> None:
    np.testing.assert_allclose(speeds(1e-3, 12.0), (12.0 - TORQUE) / MASS * STEP * np.arange(251), rtol=0, atol=4e-3)


@pytest.mark.parametrize("creep", [0.3, 0.03, 3e-3])
def test_a_block_that_is_pushed_to_and_fro_reverses_as_the_equation_says(creep: float) -> None:
    """Between reversals it gains up to 5 cm/s in a step, many times the least of these creeps."""
    pushes = 25.0 * np.sign(np.sin(2 * np.pi * 5.0 * (STEP * np.arange(250) + 0.011)))
    expected = [0.5]
    for push in pushes:

        def rate(time: float, v: Array, push: float = push) -> Array:
            del time
            return (push - TORQUE * np.tanh(v / creep)) / MASS

        expected.append(solve_ivp(rate, (0.0, STEP), [expected[-1]], "LSODA", rtol=1e-9, atol=1e-12).y[0, -1])
    found = speeds(creep, pushes, start=0.5)
    assert np.abs(np.diff(expected)).max() > 0.03
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-3)
    assert np.sqrt(np.mean((found - expected) ** 2)) < 1e-3


def test_without_torque_it_is_absent() -> None:
    np.testing.assert_allclose(speeds(0.5, 4.0, torque=0.0), 4.0 / MASS * STEP * np.arange(251), rtol=1e-9, atol=1e-12)


def test_bounds_follow_the_machine() -> None:
    torque, creep = placed(block(), "smooth_friction", "rail").parameters
    assert (torque.unit, creep.unit) == ("N", "m/s")
    assert (torque.low, torque.nominal, torque.high) == (0.0, 0.0, 10.0)
    assert 0.0 < creep.low < creep.nominal < creep.high
