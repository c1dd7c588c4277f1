"""A block on an inclined plane."""

from functools import cache

import mujoco
import numpy as np
import pytest
from effect_machines import catalogue_effect, placed, with_effect

from dr_lab.errors import ModelError
from dr_lab.physics.model import Model, from_spec
from dr_lab.trajectory import Array

GRAVITY, FRICTION, RADIUS = 9.81, 0.1, 0.05
STEEP = 0.15  # rad, beyond the angle of friction of 0.1 rad


@cache
def block() -> Model:
    """A block of 2 kg that slides on a floor without turning, soft enough to stay in contact."""
    xml = f"""<mujoco model="sliding">
      <compiler angle="radian"/>
      <option timestep="0.001" integrator="implicitfast" cone="elliptic" impratio="100" gravity="0 0 -{GRAVITY}"/>
      <default><geom friction="{FRICTION} 0 0" solref="0.05 1"/></default>
      <worldbody>
        <geom name="floor" type="plane" size="0 0 1"/>
        <body name="block" pos="0 0 {RADIUS}">
          <joint name="x" type="slide" axis="1 0 0"/>
          <joint name="y" type="slide" axis="0 1 0"/>
          <joint name="z" type="slide" axis="0 0 1"/>
          <geom type="sphere" size="{RADIUS}" mass="2"/>
        </body>
      </worldbody>
    </mujoco>"""
    return from_spec("sliding", mujoco.MjSpec.from_string(xml), {})


def settled(**angles: float) -> tuple[Array, Array]:
    """Velocity in m/s and mean acceleration in m/s² once the block has sunk into the slope, from 0.3 to 0.6 s."""
    model = with_effect(block(), "floor_slope", "floor", **angles)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 300)
    before = data.qvel.copy()
    mujoco.mj_step(model, data, 300)
    return data.qvel.copy(), (data.qvel - before) / 0.3


def sliding(angle: float) -> float:
    """g (sin α − mu cos α)."""
    return GRAVITY * (np.sin(angle) - FRICTION * np.cos(angle))


@pytest.mark.parametrize("angle", [STEEP, -STEEP])
def test_a_block_slides_down_a_steep_floor(angle: float) -> None:
    """The floor falls towards +x if it is turned about +y, and towards −y if it is turned about +x."""
    along, down = np.sign(angle) * np.cos(angle), -np.sin(abs(angle))
    for axis, direction in (("about_y", [along, 0.0, down]), ("about_x", [0.0, -along, down])):
        _, acceleration = settled(**{axis: angle})
        assert acceleration @ direction == pytest.approx(sliding(abs(angle)), rel=5e-3)
        np.testing.assert_allclose(np.cross(acceleration, direction), 0.0, atol=0.02)  # the soft contact still swings


def test_two_angles_are_one_slope() -> None:
    """The floor turns about the vector of both angles, by its length."""
    about_x, about_y = 0.12, -0.09
    _, acceleration = settled(about_x=about_x, about_y=about_y)
    assert np.linalg.norm(acceleration) == pytest.approx(sliding(np.hypot(about_x, about_y)), rel=5e-3)
    assert acceleration[0] / acceleration[1] == pytest.approx(-about_y / about_x, rel=1e-3)


def test_a_block_rests_within_the_angle_of_friction() -> None:
    speed, acceleration = settled(about_y=0.08)
    np.testing.assert_allclose(speed, 0.0, atol=1e-3)  # m/s, by which MuJoCo's soft friction creeps
    np.testing.assert_allclose(acceleration, 0.0, atol=1e-3)


def test_it_sits_at_a_floor_that_something_touches() -> None:
    assert catalogue_effect("floor_slope").sites(block().nominal()) == ("floor",)
    names = [p.name.rpartition(".")[2] for p in placed(block(), "floor_slope", "floor").parameters]
    assert names == ["about_x", "about_y"]


def standing(floor: str) -> Model:
    xml = f"""<mujoco><compiler angle="radian"/><worldbody>{floor}<body name="ball" pos="0 0 0.1"><freejoint/>
      <geom size="0.05"/></body></worldbody></mujoco>"""
    return from_spec("standing", mujoco.MjSpec.from_string(xml), {})


@pytest.mark.parametrize("orientation", ["", 'quat="0.8 0 0 0.6"', 'euler="0 0 1.2"', 'zaxis="0 0 1"'])
def test_a_floor_is_turned_however_it_is_oriented(orientation: str) -> None:
    machine = standing(f'<geom name="floor" type="plane" size="0 0 1" {orientation}/>')
    data = mujoco.MjData(with_effect(machine, "floor_slope", "floor", about_x=STEEP))
    mujoco.mj_forward(data.model, data)
    normal = data.geom("floor").xmat.reshape(3, 3)[:, 2]
    np.testing.assert_allclose(normal, [0.0, -np.sin(STEEP), np.cos(STEEP)], atol=1e-12)


def test_a_floor_in_a_frame_is_refused() -> None:
    machine = standing('<frame euler="0 0 1.2"><geom name="floor" type="plane" size="0 0 1"/></frame>')
    with pytest.raises(ModelError, match="Write the plane with a pos and an orientation of its own"):
        with_effect(machine, "floor_slope", "floor")
