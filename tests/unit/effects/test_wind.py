import mujoco
import numpy as np
import pytest
from effect_machines import catalogue_effect, motion, placed, with_effect

from dr_lab.physics.model import Model, from_spec

DENSITY, MASS, HALF = 1.2, 0.05, (0.1, 0.2, 0.05)
BOX = f'<geom type="box" size="{HALF[0]} {HALF[1]} {HALF[2]}" mass="{MASS}"/>'


def sled(option: str = f'density="{DENSITY}"', joint: str = "") -> Model:
    """A box on a level rail without friction, in air."""
    xml = f"""<mujoco><option timestep="0.002" integrator="RK4" {option}/><worldbody><body name="box">
      <joint name="rail" type="slide" axis="1 0 0"/>{joint}{BOX}
    </body></worldbody></mujoco>"""
    return from_spec("sled", mujoco.MjSpec.from_string(xml), {})


@pytest.mark.parametrize("wind", [4.0, -2.0])
def test_wind_carries_a_sled_along(wind: float) -> None:
    model = with_effect(sled(), "wind", "world", x=wind)
    time, _, speed = motion(model, 2.0).T
    rate = 2 * DENSITY * HALF[1] * HALF[2] / MASS * abs(wind)  # of (v - w)' = -c |v - w| (v - w), 1/s
    np.testing.assert_allclose(speed, wind * rate * time / (1 + rate * time), atol=1e-9)


def test_wind_adds_to_the_models_own() -> None:
    machine = sled(f'density="{DENSITY}" wind="3 1 2"')
    (x,) = placed(machine, "wind", "world").parameters
    assert (x.nominal, x.low, x.high) == (3.0, -2.0, 8.0)
    np.testing.assert_array_equal(with_effect(machine, "wind", "world", x=-1.0).opt.wind, [-1.0, 1.0, 2.0])


def test_absent_leaves_the_wind_that_the_model_declares() -> None:
    declared = {"blowing": {"target": "option.wind[0]", "unit": "m/s", "low": -1.0, "high": 4.0}}
    machine = from_spec("sled", sled(f'density="{DENSITY}" wind="1 0 2"').spec, declared)
    windy = machine.with_effect(placed(machine, "wind", "world"))
    absent = windy.compile(windy.space.vector({"blowing": 3.0}))
    np.testing.assert_array_equal(absent.opt.wind, [3.0, 0.0, 2.0])
    stronger = windy.compile(windy.space.vector({"blowing": 3.0, "wind@world.x": 1.5}))
    np.testing.assert_array_equal(stronger.opt.wind, [3.5, 0.0, 2.0])
    assert absent.nnumeric == 0


def test_only_level_directions_that_are_felt_are_offered() -> None:
    def offered(model: Model) -> list[str]:
        return [p.name.rpartition(".")[2] for p in placed(model, "wind", "world").parameters]

    assert offered(sled()) == ["x"]
    assert offered(sled(joint='<joint type="slide" axis="0 1 0"/>')) == ["x", "y"]


def test_nothing_blows_in_a_vacuum_or_on_a_vertical_rail() -> None:
    effect = catalogue_effect("wind")
    assert effect.sites(sled("").nominal()) == ()
    upright = sled().spec.copy()
    upright.joint("rail").axis = [0.0, 0.0, 1.0]
    assert effect.sites(upright.compile()) == ()
    assert effect.sites(sled('viscosity="1e-3"').nominal()) == ("world",)


def test_it_is_also_looked_for_from_half_of_the_strongest_either_way() -> None:
    """Drag grows with the square of the wind: in still air a step hardly sees a strong one."""
    one = placed(sled(), "wind", "world")
    (along,) = one.parameters
    assert sorted(start["wind@world.x"] for start in one.starts) == [along.low / 2, along.high / 2]
