import mujoco
import numpy as np
import pytest
from effect_machines import acceleration, block, hanging, placed, with_effect

from dr_lab.physics.model import from_spec

SPHERICAL = """<mujoco><worldbody><body><joint name="a" axis="1 0 0"/><joint name="b" axis="0 1 0"/>
  <geom type="capsule" size="0.01" fromto="0 0 0 0 0 -1"/></body></worldbody></mujoco>"""


def test_gravity_turns_against_the_base() -> None:
    machine = from_spec("both", mujoco.MjSpec.from_string(SPHERICAL), {})
    angle = 0.1
    about_x = with_effect(machine, "base_tilt", "world", about_x=angle).opt.gravity
    about_y = with_effect(machine, "base_tilt", "world", about_y=angle).opt.gravity
    np.testing.assert_allclose(about_x, 9.81 * np.array([0, -np.sin(angle), -np.cos(angle)]), atol=1e-12)
    np.testing.assert_allclose(about_y, 9.81 * np.array([np.sin(angle), 0, -np.cos(angle)]), atol=1e-12)
    both = with_effect(machine, "base_tilt", "world", about_x=0.05, about_y=-0.1).opt.gravity
    assert np.linalg.norm(both) == pytest.approx(9.81, rel=1e-12)


def test_tilted_pendulum_rests_along_gravity() -> None:
    model = with_effect(hanging(), "base_tilt", "world", about_y=0.1)
    assert acceleration(model, qpos=-0.1) == pytest.approx(0.0, abs=1e-12)
    assert acceleration(model, qpos=0.1) < 0


def test_only_tilts_that_are_felt_are_offered() -> None:
    assert [p.name for p in placed(hanging(), "base_tilt", "world").parameters] == ["base_tilt@world.about_y"]
    assert [p.name for p in placed(block(), "base_tilt", "world").parameters] == ["base_tilt@world.about_y"]
    effect = placed(hanging(), "base_tilt", "world").effect
    turntable = SPHERICAL.replace('<joint name="a" axis="1 0 0"/>', "").replace('axis="0 1 0"', 'axis="0 0 1"')
    weightless = SPHERICAL.replace("<worldbody>", '<option gravity="0 0 0"/><worldbody>')
    for xml, sites in ((turntable, ()), (weightless, ()), (SPHERICAL, ("world",))):
        assert effect.sites(mujoco.MjModel.from_xml_string(xml)) == sites
