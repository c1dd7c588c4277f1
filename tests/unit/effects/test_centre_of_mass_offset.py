import mujoco
import numpy as np
import pytest
from effect_machines import (
    CONF,
    acceleration,
    block,
    catalogue_effect,
    hanging,
    motion,
    placed,
    replayed,
    with_effect,
)

from dr_lab.errors import ModelError
from dr_lab.physics.model import Model, from_spec, load

SHAPE = '<geom type="capsule" size="0.01" fromto="0 0 0 0 0 -0.6" density="800"/>'


def hung(inside: str, axis: str = "0 1 0", compiler: str = "") -> Model:
    """A link from MJCF text, on a hinge at the origin."""
    xml = f"""<mujoco><compiler angle="radian" {compiler}/><worldbody><body name="rod">
      <joint name="hinge" axis="{axis}"/>{inside}</body></worldbody></mujoco>"""
    return from_spec("hung", mujoco.MjSpec.from_string(xml), {})


def test_pendulum_with_a_centre_off_its_line_rests_slanted() -> None:
    model = with_effect(hanging(), "centre_of_mass_offset", "rod", x=0.04)
    assert acceleration(model, qpos=np.arctan2(0.04, 0.3)) == pytest.approx(0.0, abs=1e-12)
    assert acceleration(model) == pytest.approx(9.81 * 0.5 * 0.04 / (0.005 + 0.5 * (0.3**2 + 0.04**2)), rel=1e-12)


def test_period_follows_steiners_theorem() -> None:
    model = with_effect(hanging(), "centre_of_mass_offset", "rod", z=-0.05)
    time, position, _ = motion(model, 2.0, qpos=1e-3).T
    omega = np.sqrt(0.5 * 9.81 * 0.35 / (0.005 + 0.5 * 0.35**2))
    np.testing.assert_allclose(position, 1e-3 * np.cos(omega * time), atol=1e-8)


@pytest.mark.parametrize(
    "inside",
    [
        SHAPE,
        SHAPE + '<geom type="box" size="0.05 0.02 0.03" pos="0.1 0 -0.6" euler="0.3 0.2 0.1"/>',
        '<inertial mass="2" pos="0 0.1 -0.3" euler="0.1 0.2 0.3" diaginertia="0.02 0.03 0.04"/>',
        '<inertial mass="2" pos="0 0.1 -0.3" fullinertia="0.03 0.03 0.03 0.005 -0.002 0.001"/>',
    ],
)
def test_mass_and_inertia_about_the_centre_stay(inside: str) -> None:
    machine = hung(inside)
    plain, moved = machine.nominal(), with_effect(machine, "centre_of_mass_offset", "rod", x=0.02, z=-0.01)
    np.testing.assert_allclose(moved.body("rod").ipos - plain.body("rod").ipos, [0.02, 0.0, -0.01], atol=1e-12)
    for name in ("mass", "inertia", "iquat"):
        np.testing.assert_allclose(getattr(moved.body("rod"), name), getattr(plain.body("rod"), name), rtol=1e-9)


def test_only_directions_that_are_felt_are_offered() -> None:
    def offered(model: Model, body: str) -> list[str]:
        return [p.name.rpartition(".")[2] for p in placed(model, "centre_of_mass_offset", body).parameters]

    assert offered(hanging(), "rod") == ["x", "z"]
    assert offered(hung(SHAPE, axis="1 0 0"), "rod") == ["y", "z"]
    assert offered(hung(SHAPE + '<joint name="other" axis="1 0 0"/>'), "rod") == ["x", "y", "z"]
    assert offered(hung('<geom size="0.1"/>'), "rod") == ["x", "z"]  # its centre is at the hinge
    assert offered(load("hopper", CONF / "model" / "hopper.xml", {}), "torso") == ["x", "z"]
    assert catalogue_effect("centre_of_mass_offset").sites(block().nominal()) == ()


def test_a_centre_on_a_vertical_axis_is_felt_in_no_direction() -> None:
    wheel = hung('<geom type="cylinder" size="0.1 0.01"/>', axis="0 0 1")
    assert catalogue_effect("centre_of_mass_offset").sites(wheel.nominal()) == ()


def test_models_that_ignore_inertial_are_refused() -> None:
    machine = hung(SHAPE, compiler='inertiafromgeom="true"')
    with pytest.raises(ModelError, match="inertiafromgeom"):
        with_effect(machine, "centre_of_mass_offset", "rod", x=0.01)


def test_a_centre_at_the_origin_and_one_off_it_go_side_by_side() -> None:
    """MuJoCo stores a body with its centre at its origin in a shorter form, which no other model may join."""
    xml = """<mujoco><worldbody><body name="rod">
      <joint type="slide" axis="1 0 0"/><joint axis="0 1 0"/>
      <inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/></body></worldbody></mujoco>"""
    model = from_spec("rolling", mujoco.MjSpec.from_string(xml), {})
    extended = model.with_effect(placed(model, "centre_of_mass_offset", "rod"))
    z = np.stack([extended.space.nominal, extended.space.high])
    paths = replayed(extended, z, np.zeros((1, 50, 0)), np.zeros((1, 5, 0)))
    alone = [replayed(extended, row[None], np.zeros((1, 50, 0)), np.zeros((1, 5, 0)))[0] for row in z]
    np.testing.assert_allclose(paths, alone, rtol=0, atol=1e-12)
    plain = replayed(model, np.empty((1, 0)), np.zeros((1, 50, 0)), np.zeros((1, 5, 0)))
    np.testing.assert_allclose(paths[:1], plain, rtol=0, atol=1e-12)
    assert np.abs(paths[1] - paths[0]).max() > 1e-3
