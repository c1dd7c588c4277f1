import mujoco
import numpy as np
import pytest
from effect_machines import CONF, block, catalogue_effect, hanging, motion, with_effect

from dr_lab.physics.model import from_spec, load


@pytest.mark.parametrize("factor", [0.5, 3.0])
def test_period_follows_the_inertia_about_the_hinge(factor: float) -> None:
    model = with_effect(hanging(), "inertia_error", "rod", factor=factor)
    time, position, _ = motion(model, 2.0, qpos=1e-3).T
    omega = np.sqrt(0.5 * 9.81 * 0.3 / (factor * 0.005 + 0.5 * 0.3**2))
    np.testing.assert_allclose(position, 1e-3 * np.cos(omega * time), atol=1e-8)


@pytest.mark.parametrize(
    "inside",
    [
        '<geom type="capsule" size="0.01" fromto="0 0 0 0.1 0 -0.6"/>',
        '<inertial mass="2" pos="0 0 -0.3" euler="0.1 0.2 0.3" diaginertia="0.02 0.03 0.04"/>',
        '<inertial mass="2" pos="0 0 -0.3" fullinertia="0.03 0.03 0.03 0.005 -0.002 0.001"/>',
    ],
)
def test_the_whole_tensor_is_scaled_and_nothing_else(inside: str) -> None:
    xml = f"""<mujoco><compiler angle="radian"/><worldbody><body name="rod"><joint name="hinge" axis="0 1 0"/>{inside}
      </body></worldbody></mujoco>"""
    machine = from_spec("rod", mujoco.MjSpec.from_string(xml), {})
    plain, scaled = machine.nominal().body("rod"), with_effect(machine, "inertia_error", "rod", factor=2.5).body("rod")
    np.testing.assert_allclose(scaled.inertia, 2.5 * plain.inertia, rtol=1e-9)
    for name in ("mass", "ipos", "iquat"):
        np.testing.assert_allclose(getattr(scaled, name), getattr(plain, name), rtol=1e-9, atol=1e-15)


def test_bodies_whose_inertia_no_joint_feels_are_left_out() -> None:
    effect = catalogue_effect("inertia_error")
    assert effect.sites(block().nominal()) == ()
    assert effect.sites(hanging().nominal()) == ("rod",)
    cartpole = load("cartpole", CONF / "model" / "cartpole.xml", {})
    assert effect.sites(cartpole.nominal()) == ("pole",)
