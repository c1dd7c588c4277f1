import mujoco
import numpy as np
import pytest
from effect_machines import catalogue_effect, placed, with_effect

from dr_lab.physics.model import Model, from_spec
from dr_lab.trajectory import Array

MASS, INERTIA, SECONDS = 0.8, (0.004, 0.005, 0.009), 2.0


def flyer(joint: str = "<freejoint/>") -> Model:
    """A body that flies without weight, beside an arm."""
    xml = f"""<mujoco><option timestep="0.001" integrator="RK4" gravity="0 0 0"/><worldbody>
      <body name="drone" quat="0.8 0.2 -0.5 0.3">{joint}
        <inertial mass="{MASS}" pos="0 0 0" diaginertia="{" ".join(map(str, INERTIA))}"/></body>
      <body name="arm" pos="0 3 0"><joint name="hinge"/><geom size="0.1" mass="1"/></body>
    </worldbody></mujoco>"""
    return from_spec("flyer", mujoco.MjSpec.from_string(xml), {})


def slowed(model: mujoco.MjModel, speed: Array) -> Array:
    """Speeds of the free joint after some seconds."""
    data = mujoco.MjData(model)
    data.qvel[:6] = speed
    mujoco.mj_step(model, data, round(SECONDS / model.opt.timestep))
    return data.qvel[:6].copy()


def test_flight_slows_exponentially_in_every_direction() -> None:
    model = with_effect(flyer(), "viscous_drag", "drone", translation=0.3)
    speed = np.array([1.0, -2.0, 0.5, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(slowed(model, speed), speed * np.exp(-0.3 * SECONDS / MASS), rtol=1e-9)


@pytest.mark.parametrize("axis", range(3))
def test_a_turn_slows_exponentially_about_each_axis_of_the_body(axis: int) -> None:
    model = with_effect(flyer(), "viscous_drag", "drone", rotation=0.002)
    speed = np.zeros(6)
    speed[3 + axis] = 3.0
    expected = speed * np.exp(-0.002 * SECONDS / INERTIA[axis])
    np.testing.assert_allclose(slowed(model, speed), expected, rtol=1e-9, atol=1e-12)


def test_it_is_sized_by_what_it_slows() -> None:
    bounds = {
        p.name.rpartition(".")[2]: (p.nominal, p.low, p.high)
        for p in placed(flyer(), "viscous_drag", "drone").parameters
    }
    assert bounds == {"translation": (0.0, 0.0, 2 * MASS), "rotation": (0.0, 0.0, 2 * INERTIA[0])}


def test_bodies_that_fly_alone_have_it() -> None:
    effect = catalogue_effect("viscous_drag")
    assert effect.sites(flyer().nominal()) == ("drone",)
    assert effect.sites(flyer('<joint name="ball" type="ball"/>').nominal()) == ()
