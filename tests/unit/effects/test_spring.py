import mujoco
import numpy as np
import pytest
from effect_machines import acceleration, block, hanging, motion, placed, scales_of, with_effect

from dr_lab.physics.model import from_spec


def test_block_swings_harmonically_about_the_reference() -> None:
    model = with_effect(block(), "spring", "rail", stiffness=8.0, reference=0.25)
    time, position, _ = motion(model, 2.0, qpos=1.0).T
    np.testing.assert_allclose(position, 0.25 + 0.75 * np.cos(np.sqrt(8.0 / 2.0) * time), atol=1e-9)


@pytest.mark.parametrize("own", ["5", "5 0.5 2", "0 0 2"])
def test_adds_exactly_to_the_joints_own_polynomial(own: str) -> None:
    machine = block(joint=f'stiffness="{own}" springref="0.3"')
    model = with_effect(machine, "spring", "rail", stiffness=8.0, reference=-1.0)
    linear, square, cube = (float(c) for c in [*own.split(), "0", "0"][:3])
    for position in np.linspace(-2.0, 2.0, 9):
        x = position - 0.3
        force = -(linear * x + square * x**2 + cube * x**3) - 8.0 * (position + 1.0)
        assert acceleration(model, qpos=position) == pytest.approx(force / 2.0, rel=1e-12, abs=1e-12)


def test_reference_is_in_radians_whatever_the_compilers_angle() -> None:
    xml = """<mujoco><compiler angle="degree"/><option gravity="0 0 0"/><worldbody><body>
      <inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
      <joint name="hinge" axis="0 1 0" stiffness="1" springref="30"/>
    </body></worldbody></mujoco>"""
    machine = from_spec("degrees", mujoco.MjSpec.from_string(xml), {})
    model = with_effect(machine, "spring", "hinge", stiffness=1.0, reference=0.5)
    assert acceleration(model, qpos=0.1) == pytest.approx(-(0.1 - np.pi / 6) - (0.1 - 0.5), rel=1e-12)


def test_absent_spring_leaves_the_joints_own_untouched() -> None:
    model = with_effect(block(joint='stiffness="5" springref="0.3"'), "spring", "rail", stiffness=0.0, reference=0.9)
    assert (model.jnt_stiffness[0], model.qpos_spring[0]) == (5.0, 0.3)


def test_reference_is_looked_for_within_the_measured_range() -> None:
    machine = hanging()
    one = placed(machine, "spring", "hinge")
    stiffness, reference = one.parameters
    assert (reference.low, reference.nominal, reference.high) == (-1.0, 0.0, 1.0)
    assert (stiffness.unit, stiffness.high) == ("N·m/rad", 20.0)
    assert {start["spring@hinge.reference"] for start in one.starts} == {-0.3, 0.3}
    still = placed(machine, "spring", "hinge", scales_of(machine, torque=0.0, speed=0.0, position=0.0))
    assert all(parameter.span > 0 for parameter in still.parameters)
