import mujoco
import numpy as np
import pytest
from effect_machines import acceleration, block, hanging, placed, with_effect

from dr_lab.errors import ModelError, UnknownNameError
from dr_lab.physics.model import Model, from_spec


def test_point_mass_adds_its_weight_and_its_inertia() -> None:
    model = with_effect(hanging(), "payload", "rod", mass=0.2, distance=0.7)
    moment, inertia = 0.5 * 0.3 + 0.2 * 0.7, 0.005 + 0.5 * 0.3**2 + 0.2 * 0.7**2
    for angle in (0.3, 1.2, -2.0):
        expected = -9.81 * moment * np.sin(angle) / inertia
        assert acceleration(model, qpos=angle) == pytest.approx(expected, rel=1e-12)


def test_bodies_that_only_slide_have_no_distance() -> None:
    assert [p.name for p in placed(block(), "payload", "block").parameters] == ["payload@block.mass"]
    model = with_effect(block(), "payload", "block", mass=0.5)
    assert acceleration(model, ctrl=5.0) == pytest.approx(5.0 / 2.5, rel=1e-12)


def rod_of_geoms(axis: str = "0 1 0", fromto: str = "0 0 0.1 0 0 -0.5", compiler: str = "") -> Model:
    """A rod whose inertia MuJoCo computes from its shape; its joint is 0.1 m below the body's origin."""
    xml = f"""<mujoco><compiler angle="radian" {compiler}/><worldbody><body name="rod">
      <joint name="hinge" axis="{axis}" pos="0 0 -0.1"/><geom type="capsule" size="0.01" fromto="{fromto}"/>
    </body></worldbody></mujoco>"""
    return from_spec("rod", mujoco.MjSpec.from_string(xml), {})


def test_distance_counts_from_the_joint_towards_the_centre_of_a_body_without_inertial() -> None:
    machine = rod_of_geoms()
    loaded = with_effect(machine, "payload", "rod", mass=1.0, distance=0.25)
    data = mujoco.MjData(loaded)
    mujoco.mj_kinematics(loaded, data)
    np.testing.assert_allclose(data.body("payload@rod").xipos, [0, 0, -0.35], atol=1e-12)
    assert loaded.dof_M0[0] - machine.nominal().dof_M0[0] == pytest.approx(0.25**2, rel=1e-9)
    np.testing.assert_array_equal(loaded.body("rod").mass, machine.nominal().body("rod").mass)


def test_a_centre_on_the_axis_still_gets_a_lever_across_it() -> None:
    machine = rod_of_geoms(axis="0 0 1")
    loaded = with_effect(machine, "payload", "rod", mass=1.0, distance=0.25)
    assert loaded.dof_M0[0] - machine.nominal().dof_M0[0] == pytest.approx(0.25**2, rel=1e-9)


def test_bounds_and_starts_are_scaled_to_the_body() -> None:
    one = placed(hanging(), "payload", "rod")
    mass, distance = one.parameters
    assert (mass.high, distance.nominal, distance.low) == (0.5, pytest.approx(0.3), 0.0)
    assert distance.high == pytest.approx(0.75)
    assert all(0 < start["payload@rod.distance"] < distance.high for start in one.starts)


def test_ignored_inertials_and_unknown_bodies_are_refused() -> None:
    with pytest.raises(ModelError, match="inertiafromgeom"):
        with_effect(rod_of_geoms(compiler='inertiafromgeom="true"'), "payload", "rod", mass=1.0)
    with pytest.raises(UnknownNameError, match="rod"):
        placed(hanging(), "payload", "rid")
