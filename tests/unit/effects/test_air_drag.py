import mujoco
import numpy as np
from effect_machines import catalogue_effect, motion, placed, with_effect

from dr_lab.physics.model import Model, from_spec

DENSITY, MASS, GRAVITY = 2.5, 0.05, 9.81
HALF = np.array([0.1, 0.2, 0.05])  # m, half-lengths of the box


def falling(option: str = "", geom: str = "") -> Model:
    """A box on a vertical rail."""
    size = " ".join(map(str, HALF))
    xml = f"""<mujoco><option timestep="0.002" integrator="RK4" {option}/><worldbody><body name="box">
      <joint name="rail" type="slide" axis="0 0 1"/><geom type="box" size="{size}" mass="{MASS}" {geom}/>
    </body></worldbody></mujoco>"""
    return from_spec("falling", mujoco.MjSpec.from_string(xml), {})


def test_box_falls_as_a_hyperbolic_tangent_up_to_its_terminal_speed() -> None:
    model = with_effect(falling(), "air_drag", "world", density=DENSITY)
    time, _, speed = motion(model, 1.5).T
    terminal = np.sqrt(MASS * GRAVITY / (2 * DENSITY * HALF[0] * HALF[1]))
    np.testing.assert_allclose(speed, -terminal * np.tanh(GRAVITY * time / terminal), atol=1e-9)
    assert -speed[-1] > 0.999 * terminal


def test_absent_is_the_models_own_medium() -> None:
    vacuum, water = falling(), falling('density="1000"')
    parameters = [placed(machine, "air_drag", "world").parameters[0] for machine in (vacuum, water)]
    assert [p.nominal for p in parameters] == [0.0, 1000.0]
    assert all(p.low == 0 and p.high == p.nominal + 5.0 for p in parameters)
    assert with_effect(water, "air_drag", "world", density=1000.0).opt.density == 1000.0


def test_absent_leaves_the_density_that_the_model_declares() -> None:
    declared = {"rho": {"target": "option.density", "unit": "kg/m3", "low": 0.5, "high": 4.0}}
    machine = from_spec("falling", falling('density="1.25"').spec, declared)
    dragged = machine.with_effect(placed(machine, "air_drag", "world"))

    def density(rho: float, drag: float = 1.25) -> float:
        return dragged.compile(dragged.space.vector({"rho": rho, "air_drag@world.density": drag})).opt.density

    assert [density(3.0), density(3.0, 1.5), density(0.5, 0.0)] == [3.0, 3.25, 0.0]
    assert dragged.nominal().nnumeric == 0


def test_machines_that_the_medium_cannot_hold_are_left_out() -> None:
    effect = catalogue_effect("air_drag")
    assert effect.sites(falling().nominal()) == ("world",)
    slippery = falling(geom='fluidshape="ellipsoid" fluidcoef="0 0 0 0 0"').nominal()
    slippery.geom_fluid[:, 6:] = 0.0  # virtual mass
    assert effect.sites(slippery) == ()
    point = falling().nominal()
    point.body_inertia[:] = 0.0
    assert effect.sites(point) == ()
