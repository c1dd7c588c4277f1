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
from dr_lab.plants.hidden.beating import Beating
from dr_lab.plants.hidden.both import Both
from dr_lab.plants.hidden.cogging import Cogging
from dr_lab.plants.hidden.constant_offset import ConstantOffset
from dr_lab.plants.hidden.dead_zone import DeadZone
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.hidden.flexible_mode import FlexibleMode
from dr_lab.plants.hidden.magnet import Magnet
from dr_lab.plants.hidden.no_effect import NoEffect
from dr_lab.plants.hidden.payload import Payload
from dr_lab.plants.hidden.quadratic_drag import QuadraticDrag
from dr_lab.plants.hidden.saturation import Saturation
from dr_lab.plants.hidden.spring import Spring
from dr_lab.plants.hidden.torque_scale import TorqueScale
from dr_lab.plants.hidden.viscous_friction import ViscousFriction
from dr_lab.plants.hidden.warming import Warming
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
    coarse = replace(TIGHT, longest_step=0.1)
    states = simulate(damped, BaseTilt(about_x=0.05), [no_command()], np.array([60.0]), accuracy=coarse)
    # Turned about +x, the base's −y side is the low one; there the pole's hinge axis lies in the plane of the tilt.
    np.testing.assert_allclose(states[0], (-math.pi / 2, 0.0, 0.0, 0.0), rtol=0, atol=1e-6)


def test_a_dead_zone_swallows_small_commands() -> None:
    command = Command(np.arange(4.0), np.array([-2.0, -0.3, 0.4, 1.0]))
    np.testing.assert_allclose(DeadZone(0.5).command("motor", command).value, [-1.5, 0.0, 0.0, 0.5])
    assert DeadZone(0.5).command("brake", command) is command


def test_cogging_and_a_magnet_give_back_what_they_take() -> None:
    inertia, start = ARM_ALONE.links[0].second, (0.35, 0.0, 3.0, 0.0)
    cogging, magnet = Cogging("arm", sine=3e-4, cosine=-2e-4, periods=12), Magnet("arm", 5e-4, place=0.5, reach=0.1)

    def ripple(angle: Array) -> Array:
        return (3e-4 * np.cos(12 * angle) + 2e-4 * np.sin(12 * angle)) / 12

    def well(angle: Array) -> Array:
        return -5e-4 * np.exp(-((angle - 0.5) ** 2) / (2 * 0.1**2))

    for effect, potential in ((cogging, ripple), (magnet, well)):
        states = simulate(ARM_ALONE, effect, [no_command()], TIME, accuracy=TIGHT, start=start)
        energy = 0.5 * inertia * states[:, 2] ** 2 + potential(states[:, 0])
        assert np.ptp(potential(states[:, 0])) > 1e-2 * energy[0]
        np.testing.assert_allclose(energy, energy[0], rtol=1e-9)


def test_beating_shakes_by_the_clock() -> None:
    states = simulate(ARM_ALONE, Beating("arm", 1e-3, 3.0), [no_command()], TIME, accuracy=TIGHT)
    turn = 2 * math.pi * 3.0
    expected = 1e-3 / ARM_ALONE.links[0].second / turn * (1 - np.cos(turn * TIME))
    np.testing.assert_allclose(states[:, 2], expected, rtol=0, atol=1e-9)


def test_warming_grease_brakes_less_and_less() -> None:
    effect, start = Warming("arm", cold=3e-4, constant=0.5), (0.0, 0.0, 5.0, 0.0)
    states = simulate(ARM_ALONE, effect, [no_command()], TIME, accuracy=TIGHT, start=start)
    braked = 3e-4 * 0.5 * (1 - np.exp(-TIME / 0.5)) / ARM_ALONE.links[0].second
    np.testing.assert_allclose(states[:, 2], 5.0 * np.exp(-braked), rtol=1e-9)


def test_a_warming_seal_takes_less_and_less() -> None:
    effect, start = Warming("arm", cold=0.0, constant=0.5, seal=2e-4, creep=1e-4), (0.0, 0.0, 5.0, 0.0)
    states = simulate(ARM_ALONE, effect, [no_command()], TIME, accuracy=TIGHT, start=start)
    lost = 2e-4 * 0.5 * (1 - np.exp(-TIME / 0.5)) / ARM_ALONE.links[0].second
    np.testing.assert_allclose(states[:, 2], 5.0 - lost, rtol=1e-9)


def test_what_sloshes_swings_against_its_link() -> None:
    inertia, rotor, stiffness, torque = ARM_ALONE.links[0].second, 5e-5, 0.02, 1e-4
    effect = Both(FlexibleMode("arm", rotor, stiffness, damping=0.0), ConstantOffset("arm", torque))
    states = simulate(ARM_ALONE, effect, [no_command()], TIME, accuracy=TIGHT)
    turn = math.sqrt(stiffness * (1 / inertia + 1 / rotor))
    behind = -torque / inertia / turn**2 * (1 - np.cos(turn * TIME))
    np.testing.assert_allclose(states[:, 2] - states[:, 0], behind, rtol=0, atol=1e-9)
    np.testing.assert_allclose(inertia * states[:, 3] + rotor * states[:, 5], torque * TIME, rtol=0, atol=1e-12)


def test_two_effects_act_together() -> None:
    both = Both(ViscousFriction("arm", 1e-4), ConstantOffset("arm", 5e-4))
    volts = 5e-4 * MOTOR.resistance / MOTOR.constant
    shifted = Command(np.concatenate([[0.0], COMMAND.edge]), np.concatenate([[0.0], COMMAND.value]) + volts)
    same(driven(QUBE, both), driven(replace(QUBE, damping=(2e-4, QUBE.damping[1])), NoEffect(), shifted))
    later = Both(ActuatorDelay(0.012), Saturation(4.5))
    same(driven(QUBE, later), driven(QUBE, Saturation(4.5), time=TIME - 0.012))
    assert both.label == "viscous_friction@arm + constant_offset@arm"
    assert both.parameters == {"viscous_friction@arm": {"coefficient": 1e-4}, "constant_offset@arm": {"torque": 5e-4}}


def test_an_effect_is_labelled_by_name_and_site() -> None:
    assert Spring("arm", 1.0).label == "spring@arm"
    assert ActuatorDelay(0.01).label == "actuator_delay@motor"
    assert NoEffect().label == "none"
