import mujoco
import numpy as np
from effect_machines import block, motion, placed, with_effect

from dr_lab.trajectory import Array

KINETIC, EXCESS, SPEED = 4.0, 6.0, 0.5


def friction_at(speeds: Array, **values: float) -> Array:
    """Force on the block at imposed speeds, from the acceleration of one forward call."""
    model = with_effect(block(), "stribeck_friction", "rail", **values)
    data, forces = mujoco.MjData(model), []
    for speed in speeds:
        data.qvel[0] = speed
        mujoco.mj_forward(model, data)
        forces.append(2.0 * data.qacc[0])
    return np.array(forces)


def test_force_follows_the_stribeck_curve() -> None:
    speeds = np.linspace(0.05, 3 * SPEED, 200)  # slower, the constraint is still within its linear zone
    force = friction_at(speeds, kinetic=KINETIC, excess=EXCESS, speed=SPEED)
    law = -(KINETIC + EXCESS * np.exp(-((speeds / SPEED) ** 2)))
    assert np.abs(force - law).max() < 0.084 * EXCESS
    assert np.sqrt(np.mean((force - law) ** 2)) < 0.03 * EXCESS
    np.testing.assert_allclose(friction_at(-speeds, kinetic=KINETIC, excess=EXCESS, speed=SPEED), -force, atol=1e-9)


def test_far_above_the_stribeck_speed_only_kinetic_friction_is_left() -> None:
    force = friction_at(np.array([10 * SPEED]), kinetic=KINETIC, excess=EXCESS, speed=SPEED)
    np.testing.assert_allclose(force, -KINETIC, rtol=1e-9)


def test_breaks_away_at_kinetic_plus_excess() -> None:
    model = with_effect(block(), "stribeck_friction", "rail", kinetic=KINETIC, excess=EXCESS, speed=SPEED)
    assert abs(motion(model, 1.0, ctrl=0.98 * (KINETIC + EXCESS))[-1, 1]) < 1e-4
    assert motion(model, 1.0, ctrl=1.05 * (KINETIC + EXCESS))[-1, 1] > 0.1


def test_without_excess_it_is_coulomb_friction_exactly() -> None:
    stribeck = with_effect(block(), "stribeck_friction", "rail", kinetic=KINETIC)
    coulomb = with_effect(block(), "coulomb_friction", "rail", torque=KINETIC)
    np.testing.assert_array_equal(motion(stribeck, 1.0, qvel=2.0), motion(coulomb, 1.0, qvel=2.0))


def test_adds_neither_command_nor_state() -> None:
    plain = block().nominal()
    model = with_effect(block(), "stribeck_friction", "rail", kinetic=KINETIC, excess=EXCESS, speed=SPEED)
    assert (model.nu, model.na, model.nv) == (plain.nu, plain.na, plain.nv)


def test_fits_start_away_from_absent_within_the_bounds() -> None:
    one = placed(block(), "stribeck_friction", "rail")
    bounds = {p.name: p for p in one.parameters}
    assert one.starts
    for start in one.starts:
        assert all(bounds[name].low < value < bounds[name].high for name, value in start.items())
