"""The equation of motion on measured motion: closed forms of a pendulum and a slider."""

import mujoco
import numpy as np
import pytest

from dr_lab.diagnosis.faults.equation_error import actuation, demand, parameter_columns, weak_form
from dr_lab.diagnosis.faults.smoothed_motion import (
    EquationErrorSettings,
    Motion,
    controls_at,
    smoothed_motion,
    untestable,
)
from dr_lab.physics.model import from_spec
from dr_lab.trajectory import Array, Log, MeasurementSet, Noise, Signal

SETTINGS = EquationErrorSettings(step=0.005, cutoff=20.0, half_width=0.1, hop=0.05)
MASS, LENGTH, GRAVITY, SERVO, BRAKE = 1.5, 0.4, 9.81, 20.0, 0.7
XML = f"""
<mujoco>
  <option gravity="0 0 -{GRAVITY}"/>
  <worldbody>
    <body name="bob">
      <joint name="hinge" axis="0 1 0" damping="{BRAKE}"/>
      <inertial pos="0 0 -{LENGTH}" mass="{MASS}" diaginertia="1e-9 1e-9 1e-9"/>
    </body>
  </worldbody>
  <actuator>{{actuator}}</actuator>
</mujoco>
"""
MOTOR, POSITION = '<motor name="motor" joint="hinge" gear="3"/>', f'<position name="motor" joint="hinge" kp="{SERVO}"/>'
AMPLITUDE, RATE = 0.6, 2 * np.pi * 1.3


def compiled(actuator: str = MOTOR) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(XML.format(actuator=actuator))


def swinging(*, velocity: bool = False, parts: tuple[tuple[float, float], ...] = ((0.0, 4.0),)) -> MeasurementSet:
    """A hinge that is held on q = A sin(ω t), sampled at 500 Hz, with a command 2 cos(3 t) at 250 Hz."""
    time = np.concatenate([np.arange(first, last, 0.002) for first, last in parts])
    true = AMPLITUDE * (RATE * np.cos(RATE * time) if velocity else np.sin(RATE * time))
    name, unit = ("hinge.velocity", "rad/s") if velocity else ("hinge.position", "rad")
    output = Signal(name, unit, time, true)
    sent = np.arange(-0.1, parts[-1][1], 0.004)
    log = Log("log", {name: output}, {"motor": Signal("motor", "N·m", sent, 2.0 * np.cos(3 * sent))})
    return MeasurementSet("m", (log,), (), {name: Noise(1e-9, unit, "given")}, {name: 0.01})


def needed(time: Array) -> Array:
    q, v, a = (
        AMPLITUDE * f for f in (np.sin(RATE * time), RATE * np.cos(RATE * time), -(RATE**2) * np.sin(RATE * time))
    )
    return MASS * LENGTH**2 * a + MASS * GRAVITY * LENGTH * np.sin(q) + BRAKE * v


@pytest.mark.parametrize("velocity", [False, True])
def test_the_demand_is_the_closed_form_of_a_pendulum(velocity: bool) -> None:
    measured, model = swinging(velocity=velocity), compiled()
    motion = smoothed_motion(model, measured, measured.fit, SETTINGS)
    found = demand(model, motion)
    np.testing.assert_allclose(found.force[20:-20, 0], needed(motion.time)[20:-20], atol=0.02)
    np.testing.assert_allclose(found.force, found.gravity + found.inertia + BRAKE * motion.qvel, atol=1e-9)
    weak = weak_form(motion, SETTINGS)
    dense = np.linspace(weak.time[3] - 0.1, weak.time[3] + 0.1, 4001)
    bump = (1 - ((dense - weak.time[3]) / 0.105) ** 2) ** 3
    assert weak.project(found.force)[3, 0] == pytest.approx(np.average(needed(dense), weights=bump), abs=0.02)


def test_a_motor_drives_and_a_servo_also_holds() -> None:
    measured = swinging()
    motion = smoothed_motion(compiled(), measured, measured.fit, SETTINGS)
    for actuator, idle, gain in ((MOTOR, 0.0 * motion.qpos, 3.0), (POSITION, -SERVO * motion.qpos, SERVO)):
        model = compiled(actuator)
        given = actuation(model, motion, controls_at(model, measured.fit, motion, straight=True))
        np.testing.assert_allclose(given.idle, idle, atol=1e-9)
        np.testing.assert_allclose(given.driven[:, 0, 0], gain * 2 * np.cos(3 * motion.time), atol=1e-3)


def test_commands_hold_come_late_and_carry_the_models_own_delay() -> None:
    measured = swinging()
    prompt, slow = compiled(), compiled(MOTOR.replace("/>", ' nsample="10" delay="0.02"/>'))
    motion = smoothed_motion(prompt, measured, measured.fit, SETTINGS)
    held = controls_at(prompt, measured.fit, motion)[:, 0]
    np.testing.assert_allclose(held, 2 * np.cos(3 * (motion.time - 0.002)), atol=5e-3)  # half a hold late
    late = controls_at(slow, measured.fit, motion)
    np.testing.assert_allclose(late[:, 0], 2 * np.cos(3 * (motion.time - 0.022)), atol=5e-3)
    np.testing.assert_allclose(actuation(slow, motion, late).driven[:, 0, 0], 3 * late[:, 0])


def test_an_activation_follows_its_command() -> None:
    lagging = compiled('<general name="motor" joint="hinge" dyntype="filter" dynprm="0.1"/>')
    measured = swinging()
    motion = smoothed_motion(lagging, measured, measured.fit, SETTINGS)
    driven = actuation(lagging, motion, controls_at(lagging, measured.fit, motion, straight=True)).driven[:, 0, 0]
    answer = 2 * np.cos(3 * motion.time - np.arctan(0.3)) / np.hypot(1, 0.3)
    np.testing.assert_allclose(driven[200:], answer[200:], atol=0.02)


def test_a_gap_and_contact_are_left_out() -> None:
    measured, model = swinging(parts=((0.0, 2.0), (2.5, 4.0))), compiled()
    motion = smoothed_motion(model, measured, measured.fit, SETTINGS)
    weak = weak_form(motion, SETTINGS, blocked=motion.time > 3.5)
    assert not ((weak.time > 1.9) & (weak.time < 2.6)).any()
    assert weak.time.max() < 3.41
    assert ((weak.time > 2.6) & (weak.time < 3.4)).sum() > 10


def test_a_parameters_column_is_the_difference_of_two_models() -> None:
    entry = {"target": "joint.hinge.damping", "unit": "N·m·s/rad", "low": 0.0, "high": 2.0}
    model = from_spec("bob", mujoco.MjSpec.from_string(XML.format(actuator=MOTOR)), {"damping": entry})
    measured = swinging()
    motion = smoothed_motion(model.nominal(), measured, measured.fit, SETTINGS)
    controls = controls_at(model.nominal(), measured.fit, motion)
    columns = parameter_columns(model.compile, model.space.nominal, np.array([0.3]), motion, controls)
    np.testing.assert_allclose(columns[..., 0], motion.qvel, atol=1e-9)


def test_unmeasured_joints_are_said() -> None:
    assert untestable(compiled(), swinging()) == ""
    other = mujoco.MjModel.from_xml_string(XML.format(actuator=MOTOR).replace('"hinge"', '"knee"'))
    assert "knee" in untestable(other, swinging())


def test_a_servo_that_integrates_its_command_begins_where_its_joint_is() -> None:
    servo = compiled('<intvelocity name="motor" joint="hinge" kp="50" actrange="-3 3"/>')
    place, rest = np.full((3, 1), 0.7), np.zeros((3, 1))
    motion = Motion(np.zeros(3, np.intp), np.array([0.0, 0.1, 0.2]), place, rest, rest, np.ones(3, bool), 0.1)
    np.testing.assert_allclose(actuation(servo, motion, rest).force, 0.0, atol=1e-12)
    np.testing.assert_allclose(actuation(servo, motion, rest + 2.0).force[-1], 50 * 2.0 * 0.3)
