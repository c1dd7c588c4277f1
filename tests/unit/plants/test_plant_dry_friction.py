"""Sticking and sliding against closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from plant_machines import ARM_ALONE, MOTOR, POLE_ALONE, QUBE, TIGHT, lively_command, no_command, samples

from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.plants.command import Command
from dr_lab.plants.hidden.asymmetric_friction import AsymmetricFriction
from dr_lab.plants.hidden.both import Both
from dr_lab.plants.hidden.coulomb_friction import CoulombFriction
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.hidden.stribeck_friction import StribeckFriction
from dr_lab.plants.motion import Accuracy, simulate

INERTIA = ARM_ALONE.links[0].second
TORQUE = 2e-3


def test_coulomb_friction_brakes_a_turning_arm_evenly_and_then_holds_it() -> None:
    time, speed = np.arange(0.0, 1.5, 0.01), 7.0
    start = (0.0, 0.0, speed, 0.0)
    states = simulate(ARM_ALONE, CoulombFriction("arm", TORQUE), [no_command()], time, accuracy=TIGHT, start=start)
    stop = speed * INERTIA / TORQUE
    assert 0.5 < stop < 1.2
    np.testing.assert_allclose(states[:, 2], np.clip(speed - TORQUE / INERTIA * time, 0.0, None), atol=1e-8)
    assert states[-1, 0] == pytest.approx(speed * stop / 2, abs=1e-9)
    assert np.ptp(states[time > stop + 0.01, 0]) == 0.0


def test_asymmetric_friction_brakes_one_way_more() -> None:
    friction, time = AsymmetricFriction("arm", TORQUE, asymmetry=0.4), np.array([0.1])
    for direction in (1, -1):
        start = (0.0, 0.0, 7.0 * direction, 0.0)
        end = simulate(ARM_ALONE, friction, [no_command()], time, accuracy=TIGHT, start=start)
        lost = (7.0 - abs(end[0, 2])) * INERTIA / 0.1
        assert lost == pytest.approx(TORQUE * (1 + 0.4 * direction), rel=1e-9)


def test_two_dry_joints_stop_each_by_itself() -> None:
    both, time = Both(CoulombFriction("arm", TORQUE), CoulombFriction("pole", 2.0)), np.arange(0.0, 1.5, 0.01)
    start = (0.0, 0.0, 7.0, -1.0)
    states = simulate(ARM_ALONE, both, [no_command()], time, accuracy=TIGHT, start=start)
    np.testing.assert_allclose(states[:, 2], np.clip(7.0 - TORQUE / INERTIA * time, 0.0, None), atol=1e-8)
    np.testing.assert_allclose(states[:, 3], np.clip(2.0 * time - 1.0, None, 0.0), atol=1e-8)


def test_two_dry_frictions_at_one_joint_are_refused() -> None:
    both = Both(CoulombFriction("arm", TORQUE), CoulombFriction("arm", TORQUE))
    with pytest.raises(ConfigError, match="one joint"):
        simulate(QUBE, both, [no_command()], samples(0.1), accuracy=TIGHT)


def test_coulomb_friction_shortens_each_half_swing_by_the_same_angle() -> None:
    stiffness = -POLE_ALONE.links[1].first * POLE_ALONE.gravity[2]
    torque, swings = 1e-9, 4
    dead = torque / stiffness
    amplitude = 1e3 * dead  # small enough for a linear pendulum
    half = math.pi / math.sqrt(stiffness / POLE_ALONE.links[1].second)
    time = np.linspace(0.0, half * swings, swings + 1)
    start = (0.0, amplitude, 0.0, 0.0)
    states = simulate(POLE_ALONE, CoulombFriction("pole", torque), [no_command()], time, accuracy=TIGHT, start=start)
    expected = (amplitude - 2 * dead * np.arange(swings + 1)) * (-1.0) ** np.arange(swings + 1)
    np.testing.assert_allclose(states[:, 1], expected, rtol=0, atol=1e-3 * dead)


def driven_arm(voltage: float) -> float:
    """Where the arm is after a second of constant voltage against static friction of 3 mN·m."""
    machine = replace(ARM_ALONE, drives=(MOTOR,))
    friction = StribeckFriction("arm", coulomb=1.5e-3, static=3e-3, speed=0.7)
    step = Command(np.array([0.0]), np.array([voltage]))
    return float(simulate(machine, friction, [step], np.array([1.0]), accuracy=TIGHT)[0, 0])


def test_static_friction_holds_up_to_its_limit_and_not_beyond() -> None:
    limit = 3e-3 * MOTOR.resistance / MOTOR.constant
    assert driven_arm(0.999 * limit) == 0.0
    assert driven_arm(1.1 * limit) > 0.1
    assert driven_arm(-1.1 * limit) == pytest.approx(-driven_arm(1.1 * limit), rel=1e-6)


def test_friction_falls_from_static_to_coulomb_as_the_arm_speeds_up() -> None:
    friction = StribeckFriction("arm", coulomb=1.5e-3, static=3e-3, speed=0.7)
    for speed in (0.05, 0.7, 2.0):
        start = (0.0, 0.0, -speed, 0.0)
        short = 1e-5
        end = simulate(ARM_ALONE, friction, [no_command()], np.array([short]), accuracy=TIGHT, start=start)
        expected = 1.5e-3 * (1 + math.exp(-((speed / 0.7) ** 2)))
        assert INERTIA * (end[0, 2] + speed) / short == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(
    "friction",
    [
        CoulombFriction("pole", 1e-4),
        StribeckFriction("arm", 1.5e-3, 3e-3, 0.7),
        Both(CoulombFriction("arm", TORQUE), CoulombFriction("pole", 3e-4)),
    ],
)
def test_stick_and_slip_do_not_depend_on_the_tolerance(friction: HiddenEffect) -> None:
    time, command = samples(2.0), lively_command(2.0)
    coarse, fine = (
        simulate(QUBE, friction, [command], time, accuracy=Accuracy(tol, tol, 0.005)) for tol in (1e-9, 1e-13)
    )
    for dry in friction.frictions():
        assert (fine[:, 2 + QUBE.joints.index(dry.joint)] == 0.0).any()
    np.testing.assert_allclose(coarse[:, :2], fine[:, :2], rtol=0, atol=1e-7)


def test_wrong_site_or_magnitude_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="pole"):
        simulate(QUBE, CoulombFriction("pol", TORQUE), [no_command()], samples(0.1), accuracy=TIGHT)
    with pytest.raises(ConfigError, match="static"):
        StribeckFriction("arm", coulomb=3e-3, static=1e-3, speed=0.7)
