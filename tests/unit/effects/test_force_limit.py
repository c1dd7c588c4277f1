"""A servo whose force ends at a limit."""

import mujoco
import numpy as np
import pytest
from effect_machines import placed, scales_of

from dr_lab.physics.model import Model, from_spec
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

MASS = 2.0  # kg
CART = """<mujoco><compiler autolimits="true"/><option timestep="0.002" integrator="implicitfast"/>
<worldbody>
  <body name="cart"><joint name="rail" type="slide" axis="1 0 0"/><geom size="0.1" mass="2"/></body>
</worldbody>
<actuator><position name="servo" joint="rail" kp="100" kv="{kv}" gear="2" {limits}/></actuator></mujoco>"""


def cart(kv: float = 0.0, limits: str = "") -> Model:
    return from_spec("cart", mujoco.MjSpec.from_string(CART.format(kv=kv, limits=limits)), {})


def velocity(model: Model, inverse: float, seconds: float) -> Array:
    """Of a cart whose target is far away."""
    extended = model.with_effect(placed(model, "force_limit", "servo"))
    z = extended.space.vector({"force_limit@servo.inverse_limit": inverse})[None]
    rest, controls = np.zeros((1, 1, 1)), np.full((1, round(seconds / 0.002), 1), 100.0)
    return Simulator(extended, 1, threads=1).replay(z, rest, rest, controls, controls[:, :1]).qvel[0, :, 0]


@pytest.mark.parametrize(("inverse", "force"), [(0.25, 4.0), (0.5, 2.0)])
def test_it_pulls_no_harder_than_the_limit(inverse: float, force: float) -> None:
    """m v' = gear F."""
    found = velocity(cart(), inverse, 0.5)
    np.testing.assert_allclose(found, 2 * force / MASS * 0.002 * np.arange(len(found)), atol=1e-9)


def test_damping_within_the_limit_does_not_slow_it_further() -> None:
    """As far from its target as this the servo is at its limit whatever its damping asks for."""
    np.testing.assert_allclose(velocity(cart(kv=5.0), 0.25, 0.5), velocity(cart(), 0.25, 0.5), atol=1e-9)


def test_a_range_beyond_the_limit_on_one_side_ends_at_it() -> None:
    """A press that pushes alone."""
    np.testing.assert_allclose(
        velocity(cart(limits='forcerange="2 5"'), 1.0, 0.2), velocity(cart(), 1.0, 0.2), atol=1e-9
    )


@pytest.mark.parametrize("limits", ['forcerange="-3 3"', 'forcerange="-3 3" forcelimited="true"'])
def test_the_narrower_limit_counts(limits: str) -> None:
    given = cart(limits=limits)
    np.testing.assert_allclose(velocity(given, 0.25, 0.2), velocity(given, 0.0, 0.2), atol=1e-12)
    np.testing.assert_allclose(velocity(given, 0.5, 0.2), velocity(cart(), 0.5, 0.2), atol=1e-12)


def test_fits_start_about_the_force_that_the_motion_needs() -> None:
    model = cart()
    effect = placed(model, "force_limit", "servo", scales_of(model, torque=8.0))
    (inverse,) = effect.parameters
    assert inverse.unit == "1/N"
    assert inverse.high == pytest.approx(1 / (0.5 * 8.0 / 2))
    assert [start[f"{effect.label}.inverse_limit"] for start in effect.starts] == pytest.approx(
        [1 / (share * 8.0 / 2) for share in (4.0, 2.0, 1.0)]
    )
