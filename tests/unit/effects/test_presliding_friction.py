"""Friction that bends before it slips, and creeps, against closed forms."""

import numpy as np
import pytest
from effect_machines import block, placed, scales_of

from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.law import History
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

MASS = 2.0  # kg, of the block
STEP = 0.002
TORQUE = 8.0  # N


def effect() -> PlacedEffect:
    return placed(block(), "presliding_friction", "rail", scales_of(block(), position=10.0, speed=20.0))


def moved(
    way: float,
    creep: float,
    command: float | Array,
    start: float = 0.0,
    history: History | None = None,
    retardation: float = 0.0,
) -> tuple[Array, Array]:
    """Positions and speeds of the block, pushed by `command` in N and begun at a speed in m/s."""
    model = block().with_effect(effect())
    controls = (np.zeros(250) + command)[None, :, None]
    z, place = np.array([[TORQUE, way, creep, retardation]]), np.zeros((1, 1, 1))
    rollout = Simulator(model, 1, threads=1).replay(z, place, place + start, controls, controls[:, :1], history)
    return rollout.qpos[0, :, 0], rollout.qvel[0, :, 0]


def test_without_a_way_it_is_smooth_friction() -> None:
    smooth = block().with_effect(
        placed(block(), "smooth_friction", "rail", scales_of(block(), position=10.0, speed=20.0))
    )
    wave = 25.0 * np.sin(2 * np.pi * 5.0 * STEP * np.arange(250))
    pushes, start = wave[None, :, None], np.full((1, 1, 1), 2.0)
    rollout = Simulator(smooth, 1, threads=1).replay(
        np.array([[TORQUE, 1.0]]), 0.0 * start, start, pushes, pushes[:, :1], None
    )
    place, speed = moved(0.0, 1.0, wave, start=2.0)
    np.testing.assert_allclose(rollout.qpos[0, :, 0], place, rtol=0, atol=1e-4)
    np.testing.assert_allclose(rollout.qvel[0, :, 0], speed, rtol=0, atol=4e-4)


def test_under_a_load_below_its_torque_it_creeps() -> None:
    """At v = c artanh(F / T), however stiff that is for the step."""
    for creep in (0.02, 1e-3):
        _, speed = moved(0.0, creep, 5.0)
        np.testing.assert_allclose(speed[-100:], creep * np.arctanh(5.0 / TORQUE), rtol=1e-3)


def test_where_it_does_not_creep_it_gives_way_as_dahls_spring() -> None:
    """½ m v² falls by the work T (s − x (1 − e^(−s/x))) over the way s."""
    way = 0.05
    place, speed = moved(way, 0.01, 0.0, start=3.0)
    gone = place[:150]
    work = TORQUE * (gone - way * (1 - np.exp(-gone / way)))
    np.testing.assert_allclose(0.5 * MASS * speed[:150] ** 2, 0.5 * MASS * 9.0 - work, rtol=2e-3)


def test_for_little_of_both_it_holds_and_slides_as_coulomb_says() -> None:
    place, _ = moved(0.0, 1e-3, 5.0)
    assert np.abs(place).max() < 5e-4  # of 31 cm without friction
    _, speed = moved(0.0, 1e-3, 12.0)
    np.testing.assert_allclose(speed, (12.0 - TORQUE) / MASS * STEP * np.arange(251), rtol=0, atol=0.01)


def test_stiff_bristles_do_not_tremble() -> None:
    """A stiffness of 8 N / 1 µm would need steps of a tenth of a millisecond."""
    wave = 6.0 * np.sin(2 * np.pi * 2.0 * STEP * np.arange(250))
    place, speed = moved(1e-6, 0.01, wave)
    assert np.abs(speed).max() < 0.02
    assert np.abs(np.diff(speed)).max() < 2e-3
    assert np.abs(place).max() < 5e-3


def test_what_was_measured_before_has_bent_the_bristles() -> None:
    steps, speed, way = 50, 0.5, 0.2
    shape = (1, steps, 1)
    history = History(np.zeros(1), np.zeros(shape), np.full(shape, speed), np.zeros(shape))
    _, found = moved(way, 0.01, 0.0, history=history)
    bend = 1 - np.exp(-speed * steps * STEP / way)
    assert found[1] == pytest.approx(-STEP * TORQUE * bend / MASS, rel=0.05)


def test_bristles_that_bend_are_damped() -> None:
    """A first step at a speed v bends them by 1 − e^(−v h / x), which costs T times that over h beside their mean."""
    way, speed, retardation = 0.2, 0.5, 0.01
    turns = speed * STEP / way
    _, found = moved(way, 0.01, 0.0, start=speed, retardation=retardation)
    bent = 1 - np.exp(-turns)
    pull = TORQUE * (1 - bent / turns + retardation * bent / STEP)
    assert found[1] - found[0] == pytest.approx(-STEP * pull / MASS, rel=0.01)


def test_bounds_follow_the_machine() -> None:
    torque, displacement, creep, retardation = placed(block(), "presliding_friction", "rail").parameters
    assert (torque.unit, displacement.unit, creep.unit, retardation.unit) == ("N", "m", "m/s", "s")
    assert (torque.low, torque.high) == (0.0, 10.0)
    assert (displacement.low, displacement.high) == (0.0, 0.005)  # of a range of 1 m
    assert creep.low > 0.0
    assert retardation.low == retardation.nominal == 0.0
