"""Motors whose actuators filter their commands, behind transmissions that give way."""

import mujoco
import numpy as np
import pytest
from effect_machines import block, placed, scales_of

from dr_lab.effects.joint_drive import JointDrive
from dr_lab.physics.law import History
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

STEP, TAU = 0.002, 0.04  # s
FILTER = f'<general name="drive" joint="rail" dyntype="filterexact" dynprm="{TAU}"/>'
SERVO = f'<position name="drive" joint="rail" kp="60" kv="8" timeconst="{TAU}"/>'
BEFORE, AFTER = 150, 100  # steps that are remembered, and that are simulated
JUMP, START = 180, 190  # steps at which the command jumps, and the window begins


def sprung(actuator: str, name: str = "joint_elasticity") -> tuple[Model, Array]:
    model = block(actuator, joint='damping="2"')
    extended = model.with_effect(placed(model, name, "rail", scales_of(model)))
    values = {"compliance": 0.004, "rotor": 0.5, "retardation": 0.02}
    z = extended.space.vector({f"{name}@rail.{key}": value for key, value in values.items()})
    return extended, z[None]


@pytest.mark.parametrize("kind", ["filter", "filterexact"])
@pytest.mark.parametrize("early", ["false", "true"])
def test_a_filter_passes_on_what_mujocos_does(kind: str, early: str) -> None:
    model = block(f'<general name="drive" joint="rail" dyntype="{kind}" dynprm="0.1" actearly="{early}"/>')
    compiled = model.nominal()
    compiled.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    motor, data = JointDrive.of([compiled], "rail"), mujoco.MjData(compiled)
    data.act[:] = 0.7
    held = np.array([[0.7]])
    for command in np.sin(np.arange(40.0)):
        given, held = motor.filtered(np.array([[command]]), held, np.array([True]))
        data.ctrl[:] = command
        mujoco.mj_step(compiled, data)
        np.testing.assert_allclose(given[0], data.actuator_force, rtol=0, atol=1e-12)
        np.testing.assert_allclose(held[0], data.act, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", ["joint_elasticity", "motor_side_elasticity"])
@pytest.mark.parametrize("actuator", [FILTER, SERVO])
def test_a_window_begins_amid_the_rise_of_a_filter(actuator: str, name: str) -> None:
    """The motor has had what the filter passed on, not what was asked for since the jump."""
    model, z = sprung(actuator, name)
    controls = np.where(np.arange(START + AFTER) < JUMP, -0.4, 0.4)[None, :, None]
    still, held = np.zeros((1, 1, 1)), np.full((1, 1, 1), -0.4)
    simulator = Simulator(model, 1, threads=1)
    truth = simulator.replay(z, still, still, controls, controls[:, :1], act=held)
    seen = slice(START - BEFORE, START)
    qpos, qvel = (0.5 * (each[:, :-1] + each[:, 1:])[:, seen] for each in (truth.qpos, truth.qvel))
    history = History(np.zeros(1), qpos, qvel, controls[:, seen])
    risen = 0.4 - 0.8 * np.exp(-(START - JUMP) * STEP / TAU)
    start = truth.qpos[:, None, START], truth.qvel[:, None, START]
    window = simulator.replay(z, *start, controls[:, START:], controls[:, :START], history, np.full((1, 1, 1), risen))
    error = np.abs(window.qpos - truth.qpos[:, START:]).max()
    assert error < 0.035 * np.ptp(truth.qpos)


def test_a_filtered_motor_goes_on_as_if_never_stopped() -> None:
    model, z = sprung(FILTER)
    one, other = Simulator(model, 1, threads=1), Simulator(model, 1, threads=1)
    for simulator in (one, other):
        simulator.set_contexts(z)
    one.step(np.full((1, 1), 2.0), 20)
    other.restore(one.memory)
    for simulator in (one, other):
        simulator.step(np.full((1, 1), -1.0), 20)
    np.testing.assert_array_equal(one.batch.bind("qpos"), other.batch.bind("qpos"))
