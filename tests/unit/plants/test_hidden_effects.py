"""Each hidden effect against a closed form or an equal machine."""

import math
from dataclasses import replace

import numpy as np
import pytest
from plant_machines import ARM_ALONE, MOTOR, POLE_ALONE, QUBE, TIGHT, UNPLUGGED, lively_command, no_command, samples

from dr_lab.plants.command import Command
from dr_lab.plants.furuta import Furuta
from dr_lab.plants.hidden.actuator_delay import ActuatorDelay
from dr_lab.plants.hidden.armature import Armature
from dr_lab.plants.hidden.base_tilt import BaseTilt
from dr_lab.plants.hidden.constant_offset import ConstantOffset
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.hidden.no_effect import NoEffect
from dr_lab.plants.hidden.payload import Payload
from dr_lab.plants.hidden.quadratic_drag import QuadraticDrag
from dr_lab.plants.hidden.saturation import Saturation
from dr_lab.plants.hidden.spring import Spring
from dr_lab.plants.hidden.torque_scale import TorqueScale
from dr_lab.plants.hidden.viscous_friction import ViscousFriction
from dr_lab.plants.moments import Moments
from dr_lab.plants.motion import simulate
from dr_lab.trajectory import Array

TIME = samples(1.5)
COMMAND = lively_command(1.5)


def driven(machine: Furuta, effect: HiddenEffect, command: Command = COMMAND, time: Array = TIME) -> Array:
    return simulate(machine, effect, [command], time, accuracy=TIGHT)


def same(first: Array, second: Array) -> None:
    assert np.abs(first[:, :2]).max() > 0.5
    np.testing.assert_allclose(first, second, rtol=0, atol=1e-8)


def test_delay_shifts_the_whole_response() -> None:
    late, plain = driven(QUBE, ActuatorDelay(0.012)), driven(QUBE, NoEffect(), time=TIME - 0.012)
    same(late, plain)


def test_saturation_is_a_clipped_command() -> None:
    clipped = replace(COMMAND, value=np.clip(COMMAND.value, -4.5, 4.5))
    assert (np.abs(COMMAND.value) > 4.5).mean() > 0.02
    same(driven(QUBE, Saturation(4.5)), driven(QUBE, NoEffect(), clipped))


def test_a_weaker_drive_is_a_heavier_machine() -> None:
    def scaled(body: Moments) -> Moments:
        return Moments(body.mass / 0.85, body.first / 0.85, body.second / 0.85)

    links = (scaled(QUBE.links[0]), scaled(QUBE.links[1]))
    heavier = replace(QUBE, links=links, damping=(QUBE.damping[0] / 0.85, QUBE.damping[1] / 0.85))
    same(driven(QUBE, TorqueScale(0.85)), driven(heavier, NoEffect()))


def test_constant_torque_is_a_constant_voltage() -> None:
    volts = 5e-4 * MOTOR.resistance / MOTOR.constant
    shifted = Command(np.concatenate([[0.0], COMMAND.edge]), np.concatenate([[0.0], COMMAND.value]) + volts)
    same(driven(QUBE, ConstantOffset("arm", 5e-4)), driven(QUBE, NoEffect(), shifted))


def test_viscous_friction_is_more_damping() -> None:
    doubled = replace(QUBE, damping=(2e-4, QUBE.damping[1]))
    same(driven(QUBE, ViscousFriction("arm", 1e-4)), driven(doubled, NoEffect()))


def test_armature_at_the_arm_is_a_heavier_arm() -> None:
    heavier = replace(QUBE, links=(QUBE.links[0] + Moments(0.0, 0.0, 4e-5), QUBE.links[1]))
    same(driven(QUBE, Armature("arm", 4e-5)), driven(heavier, NoEffect()))


def test_spring_swings_the_arm_about_its_rest() -> None:
    spring, start = Spring("arm", stiffness=3e-3, rest=0.1), (0.5, 0.0, 0.0, 0.0)
    states = simulate(ARM_ALONE, spring, [no_command()], TIME, accuracy=TIGHT, start=start)
    expected = 0.1 + 0.4 * np.cos(math.sqrt(3e-3 / ARM_ALONE.links[0].second) * TIME)
    np.testing.assert_allclose(states[:, 0], expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("speed", [12.0, -12.0])
def test_quadratic_drag_slows_as_one_over_time(speed: float) -> None:
    start = (0.0, 0.0, speed, 0.0)
    states = simulate(ARM_ALONE, QuadraticDrag("arm", 2e-5), [no_command()], TIME, accuracy=TIGHT, start=start)
    expected = speed / (1 + 2e-5 * abs(speed) * TIME / ARM_ALONE.links[0].second)
    np.testing.assert_allclose(states[:, 2], expected, rtol=1e-9)


def test_payload_changes_the_poles_frequency() -> None:
    first = 0.024 * 0.129 / 2 + 4e-3 * 0.12
    second = 0.024 * 0.129**2 / 3 + 4e-3 * 0.12**2
    states = simulate(
        POLE_ALONE, Payload("pole", 4e-3, 0.12), [no_command()], TIME, accuracy=TIGHT, start=(0.0, 1e-5, 0.0, 0.0)
    )
    expected = 1e-5 * np.cos(math.sqrt(9.81 * first / second) * TIME)
    np.testing.assert_allclose(states[:, 1], expected, rtol=0, atol=1e-12)


def test_payload_on_the_arm_turns_with_it() -> None:
    loaded = QUBE.with_load("arm", 0.01, 0.05)
    assert Payload("arm", 0.01, 0.05).alter(QUBE) == loaded
    assert loaded.mass((0.0, 0.0))[0][0] - QUBE.mass((0.0, 0.0))[0][0] == pytest.approx(0.01 * 0.05**2)


def test_on_a_tilted_base_the_arm_comes_to_rest_downhill() -> None:
    damped = replace(QUBE, damping=(1e-3, 1e-3), drives=(UNPLUGGED,))
    states = simulate(damped, BaseTilt(about_x=0.05), [no_command()], np.array([60.0]), accuracy=TIGHT)
    # Turned about +x, the base's −y side is the low one; there the pole's hinge axis lies in the plane of the tilt.
    np.testing.assert_allclose(states[0], (-math.pi / 2, 0.0, 0.0, 0.0), rtol=0, atol=1e-6)


def test_an_effect_is_labelled_by_name_and_site() -> None:
    assert Spring("arm", 1.0).label == "spring@arm"
    assert ActuatorDelay(0.01).label == "actuator_delay@motor"
    assert NoEffect().label == "none"
