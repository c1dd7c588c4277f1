import mujoco
import numpy as np
import pytest
from effect_machines import CONF, block, catalogue_effect, hanging, placed, with_effect
from paper_elbow import on_paper

from dr_lab.errors import ModelError
from dr_lab.physics.model import Model, from_spec, load

LENGTH, EXCESS = 0.3, 0.04  # m
FRAMED = """<mujoco><compiler angle="radian"/><worldbody><body name="upper"><joint name="a" axis="0 1 0"/>
  <geom size="0.1" mass="1"/><frame pos="0.1 0 0"><body name="lower" pos="0.2 0 0"><joint name="b" axis="0 1 0"/>
  <geom size="0.1" mass="1"/></body></frame></body></worldbody></mujoco>"""


def elbow() -> Model:
    return load("elbow", CONF / "model" / "strangers" / "elbow.xml", {})


@pytest.mark.parametrize("excess", [0.0, EXCESS, -0.1])
def test_masses_and_forces_are_those_of_lagranges_equations(excess: float) -> None:
    model = with_effect(elbow(), "link_length", "forearm", excess=excess)
    data, mass = mujoco.MjData(model), np.zeros((2, 2))
    for position, velocity in (([0.3, 0.9], [1.0, -2.0]), ([-1.2, 2.0], [0.5, 3.0])):
        data.qpos[:], data.qvel[:] = position, velocity
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, mass)
        machine = on_paper(LENGTH + excess)
        np.testing.assert_allclose(mass, machine.mass(position), rtol=1e-9)
        np.testing.assert_allclose(-data.qfrc_bias, machine.own_force(position, velocity), rtol=1e-9)


def test_bodies_without_a_link_before_them_are_no_sites() -> None:
    effect = catalogue_effect("link_length")
    assert effect.sites(elbow().nominal()) == ("forearm",)
    assert effect.sites(hanging().nominal()) == effect.sites(block().nominal()) == ()


def test_the_bounds_are_shares_of_the_link() -> None:
    (excess,) = placed(elbow(), "link_length", "forearm").parameters
    assert (excess.low, excess.high) == pytest.approx((-0.5 * LENGTH, 0.5 * LENGTH))


def test_an_offset_along_the_axis_stays() -> None:
    text = (CONF / "model" / "strangers" / "elbow_bodies.xml").read_text(encoding="utf-8")
    model = from_spec("bent", mujoco.MjSpec.from_string(text.replace('pos="0.3 0 0"', 'pos="0.3 0.07 0"')), {})
    longer = with_effect(model, "link_length", "forearm", excess=EXCESS)
    np.testing.assert_allclose(longer.body("forearm").pos, [LENGTH + EXCESS, 0.07, 0.0], atol=1e-12)


def test_places_in_a_frame_are_refused() -> None:
    framed = from_spec("framed", mujoco.MjSpec.from_string(FRAMED), {})
    with pytest.raises(ModelError, match="Write the body and the joint with a pos of their own"):
        framed.with_effect(placed(framed, "link_length", "lower")).nominal()
