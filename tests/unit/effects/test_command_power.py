"""Powers of a command against closed forms."""

import numpy as np
import pytest
from effect_machines import block, catalogue_effect, placed

from dr_lab.effects.actuator_effect import ActuatorEffect
from dr_lab.effects.command_power import CommandPower
from dr_lab.physics.law import Influence, Moment
from dr_lab.physics.simulator import Simulator

FULL = 4.0
SERVO = '<position name="drive" joint="rail" kp="50"/>'
SERIES = np.array([[[-4.0, -2.0, -1.0, 0.0, 0.5, 4.0, 8.0]]])


def test_commands_are_raised_to_a_power_and_stay_at_the_full_one() -> None:
    model = block().with_effect(placed(block(), "command_power", "drive"))
    z = np.array([[1.0, FULL], [2.0, FULL], [0.5, FULL]])
    found = model.command(z, "drive", SERIES)[:, 0]
    squared = [-4.0, -1.0, -0.25, 0.0, 0.0625, 4.0, 16.0]
    rooted = [-4.0, -np.sqrt(8.0), -2.0, 0.0, np.sqrt(2.0), 4.0, np.sqrt(32.0)]
    np.testing.assert_allclose(found, [SERIES[0, 0], squared, rooted], rtol=1e-12)
    np.testing.assert_array_equal(found[0], SERIES[0, 0])  # absent to the last digit


@pytest.mark.parametrize("exponent", [0.3, 1.0, 3.0])
def test_a_power_is_odd_and_scales(exponent: float) -> None:
    effect = catalogue_effect("command_power")
    assert isinstance(effect, CommandPower)
    values = {"exponent": np.array(exponent), "full": np.array(FULL)}
    asked = np.random.default_rng(0).normal(size=50)
    once, twice = effect.output(values, asked), effect.output(values, 2.0 * asked)
    np.testing.assert_allclose(effect.output(values, -asked), -once, rtol=1e-12)
    np.testing.assert_allclose(twice, 2.0**exponent * once, rtol=1e-12)


def test_the_machine_feels_the_thrust() -> None:
    model = block().with_effect(placed(block(), "command_power", "drive"))
    held, z = np.full((1, 50, 1), -2.0), np.array([[1.0, FULL], [2.0, FULL]])
    still = np.zeros((2, 1, 1))
    rollout = Simulator(model, 2, threads=1).replay(z, still, still, held, np.zeros((1, 30, 1)))
    np.testing.assert_allclose(rollout.qvel[:, -1, 0], [-0.1, -0.05])  # 2 N, of which the power makes 1; 2 kg, 0.1 s


def test_step_by_step_it_is_the_series() -> None:
    effect = catalogue_effect("command_power")
    assert isinstance(effect, CommandPower)
    values = {"exponent": np.array([2.0, 0.5]), "full": np.array([FULL, 1.0])}
    driver, zero = effect.driver(values, 0, 0.002), np.zeros((2, 1))
    moment, made = Moment(0.002, np.zeros(2), zero, zero, zero, zero, zero), []
    for command in SERIES[0, 0]:
        influence = Influence(np.full((2, 1), command), zero, zero, zero)
        driver.act(moment, influence)
        made.append(influence.control[:, 0])
    rows = {name: value[:, None] for name, value in values.items()}
    np.testing.assert_array_equal(np.array(made).T, effect.output(rows, SERIES[0]))


@pytest.mark.parametrize("name", ["command_power", "dead_zone", "voltage_sag"])
def test_what_depends_on_the_size_of_a_command_is_not_at_a_position_servo(name: str) -> None:
    effect = catalogue_effect(name)
    assert isinstance(effect, ActuatorEffect)
    assert effect.sites(block().nominal()) == ("drive",)
    assert effect.sites(block(SERVO).nominal()) == ()


def test_bounds_follow_the_commands() -> None:
    exponent, full = placed(block(), "command_power", "drive").parameters
    assert (exponent.low, exponent.nominal, exponent.high) == (0.3, 1.0, 3.0)
    assert (full.low, full.nominal, full.high) == (1.0, 5.0, 25.0)
