import mujoco
import numpy as np
import pytest
from effect_machines import acceleration, block, motion, placed, with_effect

from dr_lab.physics.model import from_spec


def test_force_is_constant_and_adds_to_the_command() -> None:
    model = with_effect(block(), "constant_offset", "rail", torque=-3.0)
    for position, speed in ((0.0, 0.0), (2.0, -1.0)):
        assert acceleration(model, position, speed, ctrl=8.0) == pytest.approx((8.0 - 3.0) / 2.0, rel=1e-12)


def test_command_and_state_keep_their_sizes() -> None:
    plain, model = block().nominal(), with_effect(block(), "constant_offset", "rail", torque=1.0)
    assert (model.nu, model.na) == (plain.nu, plain.na)
    assert placed(block(), "actuator_delay", "drive").effect.sites(model) == ("drive",)


def test_defaults_of_the_models_actuators_do_not_touch_it() -> None:
    xml = """<mujoco><option gravity="0 0 0"/>
      <default><general gear="200" forcerange="-1 1" ctrlrange="-1 1" damping="3" armature="7"/></default>
      <worldbody><body><inertial mass="2" pos="0 0 0" diaginertia="1 1 1"/>
        <joint name="rail" type="slide" axis="1 0 0"/></body></worldbody></mujoco>"""
    machine = from_spec("geared", mujoco.MjSpec.from_string(xml), {})
    model = with_effect(machine, "constant_offset", "rail", torque=5.0)
    assert acceleration(model, qvel=1.0) == pytest.approx(5.0 / 2.0, rel=1e-12)
    text = machine.with_effect(placed(machine, "constant_offset", "rail")).spec_at(np.array([5.0]))
    text.compile()
    exported = mujoco.MjModel.from_xml_string(text.to_xml())
    assert acceleration(exported, qvel=1.0) == pytest.approx(5.0 / 2.0, rel=1e-12)


def test_on_a_spring_it_shifts_the_rest_position() -> None:
    machine = block(joint='damping="8"').with_effect(placed(block(), "spring", "rail"))
    machine = machine.with_effect(placed(block(), "constant_offset", "rail"))
    values = {"spring@rail.stiffness": 10.0, "spring@rail.reference": 0.2, "constant_offset@rail.torque": 3.0}
    rest = motion(machine.compile(machine.space.vector(values)), 10.0)[-1, 1]
    assert rest == pytest.approx(0.2 + 3.0 / 10.0, abs=1e-6)


def test_bounds_reach_the_joints_torque_both_ways() -> None:
    (parameter,) = placed(block(), "constant_offset", "rail").parameters
    assert (parameter.low, parameter.nominal, parameter.high, parameter.unit) == (-10.0, 0.0, 10.0, "N")
