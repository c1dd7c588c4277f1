import mujoco
import numpy as np
import pytest
from effect_machines import block, catalogue_effect, motion, placed, scales_of, with_effect

from dr_lab.effects.end_stop import EndStop
from dr_lab.physics.model import Model, from_spec

FAR = 3.0  # m, where the absent stop of the block is


def stop() -> EndStop:
    effect = catalogue_effect("end_stop")
    assert isinstance(effect, EndStop)
    return effect


def test_block_stops_at_the_stop_and_presses_in_as_far_as_the_constraint_gives() -> None:
    model = with_effect(block(), "end_stop", "rail", lower=-FAR, upper=0.5)
    position = motion(model, 3.0, ctrl=4.0)[:, 1]
    softness = (stop().time_constant * stop().damping_ratio) ** 2  # s²
    pressed = (4.0 / 2.0) * (1 - stop().impedance) * softness
    assert position[-1] - 0.5 == pytest.approx(pressed, rel=0.02)


@pytest.mark.parametrize("side", [-1, 1])
def test_impact_is_damped_within_the_time_constant_and_does_not_throw_back(side: int) -> None:
    model = with_effect(block(), "end_stop", "rail", lower=-0.3, upper=0.3)
    _, position, speed = motion(model, 1.0, qvel=2.0 * side).T
    impact = int(np.argmax(side * position >= 0.3))  # RK4 feels it a step earlier
    np.testing.assert_allclose(speed[: impact - 1], 2.0 * side, atol=1e-12)
    assert np.max(side * position) - 0.3 < 2.0 * stop().time_constant / 2 * 1.1  # v/b, b = 2/T
    assert np.min(side * speed) > -0.15 * 2.0


def test_stops_that_are_absent_leave_the_motion() -> None:
    one = with_effect(block(), "end_stop", "rail", lower=-FAR, upper=FAR)
    np.testing.assert_array_equal(motion(one, 1.0, ctrl=2.0), motion(block().nominal(), 1.0, ctrl=2.0))


def test_crossing_stops_hold_the_joint_half_way() -> None:
    model = with_effect(block(), "end_stop", "rail", lower=0.4, upper=-0.2)
    assert motion(model, 2.0, qpos=0.0)[-1, 1] == pytest.approx(0.1, abs=1e-3)


def hinged(range_: str) -> Model:
    xml = f"""<mujoco><compiler angle="degree"/><worldbody><body><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
      <joint name="hinge" axis="0 1 0" {range_} solreflimit="0.05 0.7"/></body></worldbody></mujoco>"""
    return from_spec("hinged", mujoco.MjSpec.from_string(xml), {})


def test_a_range_of_its_own_is_narrowed_in_its_own_unit_and_keeps_its_constraint() -> None:
    model = with_effect(hinged('range="-30 60"'), "end_stop", "hinge", lower=-1.0, upper=0.4)
    np.testing.assert_allclose(model.jnt_range[0], [-np.pi / 6, 0.4], rtol=1e-9)
    np.testing.assert_array_equal(model.jnt_solref[0], [0.05, 0.7])
    free = with_effect(hinged(""), "end_stop", "hinge", lower=-1.0, upper=0.4)
    np.testing.assert_allclose(free.jnt_range[0], [-1.0, 0.4], rtol=1e-9)
    np.testing.assert_array_equal(free.jnt_solref[0], [stop().time_constant, stop().damping_ratio])


def test_stops_are_looked_for_within_the_measured_range_and_absent_outside_it() -> None:
    machine = block()
    one = placed(machine, "end_stop", "rail", scales_of(machine, position=0.8))
    lower, upper = one.parameters
    assert lower.nominal == lower.low == -upper.nominal == -upper.high
    assert upper.nominal >= FAR * 0.8
    assert (upper.low, lower.high) == pytest.approx((-0.8, 0.8))
    assert {"end_stop@rail.lower": -0.45 * 0.8, "end_stop@rail.upper": 0.45 * 0.8} in [
        pytest.approx(dict(start)) for start in one.starts
    ]
    hinge = placed(hinged(""), "end_stop", "hinge", scales_of(hinged(""), position=0.1)).parameters[1]
    assert hinge.nominal == pytest.approx(2 * np.pi)
