import mujoco
import numpy as np
import pytest
from effect_machines import block, placed, with_effect

from dr_lab.errors import ModelError
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

STEP, STEPS, EDGE, FORCE = 0.002, 60, 10, 4.0


INTEGRATORS = pytest.mark.parametrize("integrator", ["RK4", "EULER", "IMPLICITFAST"])


def late(machine: Model) -> Model:
    return machine.with_effect(placed(machine, "actuator_delay", "drive")).replayed()


def motions(integrator: str, delays: list[float], commands: Array) -> Array:
    """Speed of the block after each step under several delays, shape (delays, steps); the command was 0 before."""
    machine = block()
    machine.spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}")
    model = late(machine)
    z, count = np.array(delays)[:, None], len(delays)
    rollout = Simulator(model, count, threads=1).replay(
        z, np.zeros((count, 1, 1)), np.zeros((count, 1, 1)), commands[None, :, None], np.zeros((1, 30, 1))
    )
    return rollout.qvel[:, 1:, 0]


@INTEGRATORS
def test_impulse_is_lost_in_proportion_to_the_delay_from_zero_on(integrator: str) -> None:
    delays = [0.0, 1e-6, 0.0005, 0.0019, 0.002, 0.0021, 0.0029, 0.003, 0.0031, 0.0071, 0.0333, 0.05]
    speed = motions(integrator, delays, np.where(np.arange(STEPS) < EDGE, 0.0, FORCE))[:, -1]
    np.testing.assert_allclose(speed, FORCE / 2.0 * ((STEPS - EDGE) * STEP - np.array(delays)), rtol=1e-9)


def test_an_edge_that_is_late_leaves_the_block_where_it_belongs() -> None:
    """½ F/m (t − delay)², whatever part of a step the delay is; straight lines would be up to 1 µm off."""
    delays = np.array([0.0, 0.0004, 0.001, 0.0113, 0.0118])
    model, still = late(block()), np.zeros((len(delays), 1, 1))
    edge = np.where(np.arange(STEPS) < EDGE, 0.0, FORCE)[None, :, None]
    rollout = Simulator(model, len(delays), threads=1).replay(delays[:, None], still, still, edge, np.zeros((1, 30, 1)))
    since = (STEPS - EDGE) * STEP - delays
    np.testing.assert_allclose(rollout.qpos[:, -1, 0], 0.5 * FORCE / 2.0 * since**2, atol=2e-9)


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


def test_delays_too_short_for_mujoco_are_left_out_of_files() -> None:
    one, option = placed(block(), "actuator_delay", "drive"), block().spec.option
    assert "0.0025 s late" in one.effect.lacking("drive", {"delay": 0.0025}, option)
    assert not one.effect.lacking("drive", {"delay": 0.0031}, option)
    assert not one.effect.lacking("drive", {"delay": 0.0}, option)


def test_commands_are_shifted_along_a_smooth_curve() -> None:
    """A spline gives a parabola back, so a late parabola is the same one, later."""
    model, series = late(block()), (np.arange(40.0) ** 2)[None, None]
    delays = np.array([0.0, 0.0007, 0.0025, 0.0131])
    expected = (np.arange(40.0) - delays[:, None] / STEP) ** 2
    np.testing.assert_allclose(model.command(delays[:, None], "drive", series)[:, 0, 10:-1], expected[:, 10:-1])
    assert model.command(np.zeros((1, 1)), "drive", series) is series
    assert model.command(delays[:, None], "another", series) is series


@pytest.mark.parametrize("span", ["", 'ctrlrange="0 4"', 'ctrlrange="-4 4"'])
def test_pulses_up_to_the_end_of_the_range_keep_their_impulse(span: str) -> None:
    machine = block(actuator=f'<motor name="drive" joint="rail" {span}/>')
    pulses = np.where((np.arange(STEPS) // 5) % 2 == 1, FORCE, 0.0) * (np.arange(STEPS) < STEPS - 20)
    delays = STEP * (5 + np.array([0.0, 1 / 3, 0.5, 2 / 3]))
    still = np.zeros((4, 1, 1))
    rollout = Simulator(late(machine), 4, threads=1).replay(
        delays[:, None], still, still, pulses[None, :, None], np.zeros((1, 30, 1))
    )
    np.testing.assert_allclose(rollout.qvel[:, -1, 0], pulses.sum() * STEP / 2.0, rtol=1e-9)


@pytest.mark.parametrize("first", ["actuator_delay", "dead_zone"])
def test_a_dead_zone_takes_its_share_before_the_delay_acts(first: str) -> None:
    model = block()
    for name in (first, "dead_zone" if first == "actuator_delay" else "actuator_delay"):
        model = model.with_effect(placed(block(), name, "drive"))
    z = model.space.vector({"actuator_delay@drive.delay": 5.5 * STEP, "dead_zone@drive.width": 1.0})
    pulses = np.where((np.arange(STEPS) // 5) % 2 == 1, FORCE, 0.0) * (np.arange(STEPS) < STEPS - 20)
    found = model.replayed().command(z[None], "drive", pulses[None, None])
    assert found.sum() == pytest.approx(0.75 * pulses.sum())


def test_an_actuator_with_a_delay_of_its_own_is_refused() -> None:
    machine = block(actuator='<motor name="drive" joint="rail" delay="0.01" nsample="5"/>')
    with pytest.raises(ModelError, match="already keeps 5 commands"):
        with_effect(machine, "actuator_delay", "drive", delay=0.02)
    with pytest.raises(ModelError, match="already keeps 5 commands"):
        late(machine).nominal()
