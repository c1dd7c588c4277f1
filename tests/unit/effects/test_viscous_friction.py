import mujoco
import numpy as np
import pytest
from effect_machines import block, motion, placed, scales_of, with_effect

from dr_lab.errors import ModelError, UnknownNameError


def test_speed_decays_exponentially() -> None:
    time, _, speed = motion(with_effect(block(), "viscous_friction", "rail", coefficient=3.0), 1.0, qvel=2.0).T
    np.testing.assert_allclose(speed, 2.0 * np.exp(-3.0 / 2.0 * time), rtol=1e-9)


def test_coefficient_adds_to_the_joints_own() -> None:
    compiled = with_effect(block(joint='damping="1 0.5"'), "viscous_friction", "rail", coefficient=3.0)
    assert compiled.dof_damping[0] == 4.0
    assert compiled.dof_dampingpoly[0, 0] == 0.5


def test_upper_bound_is_twice_torque_over_speed_and_stays_positive() -> None:
    machine = block()
    (parameter,) = placed(machine, "viscous_friction", "rail", scales_of(machine, torque=6.0, speed=3.0)).parameters
    assert (parameter.high, parameter.unit) == (4.0, "N·s/m")
    (parameter,) = placed(machine, "viscous_friction", "rail", scales_of(machine, torque=0.0, speed=0.0)).parameters
    assert parameter.high > 0


def test_unknown_joint_names_the_joints() -> None:
    with pytest.raises(UnknownNameError, match="rail"):
        placed(block(), "viscous_friction", "rial")


def test_springdamper_is_refused() -> None:
    machine = block(joint='springdamper="0.5 1"')
    with pytest.raises(ModelError, match="springdamper"):
        with_effect(machine, "viscous_friction", "rail", coefficient=1.0)


def test_free_joints_are_no_site() -> None:
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body><freejoint name="float"/><geom size="0.1"/></body></worldbody></mujoco>'
    )
    assert placed(block(), "viscous_friction", "rail").effect.sites(model) == ()
