import mujoco
import numpy as np
import pytest
from effect_machines import block, placed, with_effect

from dr_lab.errors import ModelError
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

STEP, STEPS, FORCE = 0.002, 50, 4.0


INTEGRATORS = pytest.mark.parametrize("integrator", ["RK4", "EULER", "IMPLICITFAST"])


def motions(integrator: str, delays: list[float], commands: Array) -> Array:
    """Speed of the block after each step under several delays, shape (delays, steps); the command was 0 before."""
    machine = block()
    machine.spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}")
    model = machine.with_effect(placed(machine, "actuator_delay", "drive"))
    z, count = np.array(delays)[:, None], len(delays)
    rollout = Simulator(model, count, threads=1).replay(
        z, np.zeros((count, 1, 1)), np.zeros((count, 1, 1)), commands[None, :, None], np.zeros((1, 30, 1))
    )
    return rollout.qvel[:, 1:, 0]


@INTEGRATORS
def test_impulse_is_lost_in_proportion_to_the_delay_from_zero_on(integrator: str) -> None:
    delays = [0.0, 1e-6, 0.0005, 0.0019, 0.002, 0.0021, 0.0029, 0.003, 0.0031, 0.0071, 0.0333, 0.05]
    speed = motions(integrator, delays, np.full(STEPS, FORCE))[:, -1]
    np.testing.assert_allclose(speed, FORCE / 2.0 * (STEPS * STEP - np.array(delays)), rtol=1e-9)


@INTEGRATORS
def test_sine_arrives_late_by_the_delay(integrator: str) -> None:
    commands = np.sin(20.0 * STEP * (np.arange(200) + 0.5))
    delays = [0.0013, 0.0026, 0.0117]
    late = motions(integrator, delays, commands)
    for delay, speed in zip(delays, late, strict=True):
        time = np.arange(1, 201) * STEP - delay
        expected = np.where(time > 0, (1 - np.cos(20.0 * time)) / (2.0 * 20.0), 0.0)
        np.testing.assert_allclose(speed, expected, atol=2e-5 * expected.max() + 2e-5)


def test_history_has_one_length_and_reaches_the_longest_delay() -> None:
    absent, longest = (with_effect(block(), "actuator_delay", "drive", delay=d) for d in (0.0, 0.05))
    assert absent.nhistory == longest.nhistory
    assert absent.actuator_delay[0] == 0.0
    assert longest.actuator_delay[0] == 0.05 + STEP / 2
    assert longest.actuator_history[0, 0] * STEP >= longest.actuator_delay[0]


def test_delays_too_short_for_mujoco_are_left_to_the_commands() -> None:
    one = placed(block(), "actuator_delay", "drive")
    model, series = block().with_effect(one), np.arange(10.0)[None, None]
    short, long = (np.array([[delay]]) for delay in (0.0025, 0.0031))
    np.testing.assert_allclose(model.command(short, "drive", series)[0, 0, 2:], np.arange(2.0, 10.0) - 1.25)
    assert model.command(long, "drive", series) is series
    assert model.command(short, "another", series) is series
    assert "0.0025 s late" in one.effect.lacking("drive", {"delay": 0.0025}, model.spec.option)
    assert not one.effect.lacking("drive", {"delay": 0.0031}, model.spec.option)


def test_an_actuator_with_a_delay_of_its_own_is_refused() -> None:
    machine = block(actuator='<motor name="drive" joint="rail" delay="0.01" nsample="5"/>')
    with pytest.raises(ModelError, match="already keeps 5 commands"):
        with_effect(machine, "actuator_delay", "drive", delay=0.02)
