"""A filter step by step does what the whole series through it does, and forgets and remembers as told."""

import numpy as np
import pytest
from effect_machines import block, catalogue_effect, placed

from dr_lab.physics.effect_parts import StepwiseFilter
from dr_lab.physics.law import Influence, Law, Moment
from dr_lab.trajectory import Array

COMMANDS = np.array([1.0, 3.0, 3.0, -2.0, 0.5, 0.5])
STEP = 0.002
TAU = np.array([0.003, 0.02])  # s, one for each simulation


def driver(name: str, **values: Array) -> Law:
    effect = catalogue_effect(name)
    assert isinstance(effect, StepwiseFilter)
    return effect.driver(values, 0, STEP)


def lag() -> Law:
    return driver("actuator_lag", tau=TAU)


def played(driver: Law, commands: Array) -> Array:
    """Outputs (steps, 2) of two simulations under the same commands."""
    outputs = []
    for command in commands:
        zero = np.zeros((2, 1))
        influence = Influence(np.full((2, 1), command), zero, zero, zero)
        driver.act(Moment(STEP, np.zeros(2), zero, zero, zero, zero, zero), influence)
        outputs.append(influence.control[:, 0])
    return np.array(outputs)


@pytest.mark.parametrize("name", ["actuator_lag", "rate_limit", "dead_zone", "voltage_sag"])
def test_steps_are_the_series(name: str) -> None:
    one = placed(block(), name, "drive")
    (parameter,) = one.parameters
    values = np.array([0.2, 0.7]) * parameter.high
    series = block().with_effect(one).command(values[:, None], "drive", COMMANDS[None, None])
    stepped = played(driver(name, **one.local({parameter.name: values})), COMMANDS)
    np.testing.assert_array_equal(stepped, series[:, 0].T)
    assert not np.array_equal(stepped[:, 0], stepped[:, 1])


@pytest.mark.parametrize("name", ["actuator_lag", "rate_limit", "dead_zone"])
def test_one_value_filters_series_that_differ(name: str) -> None:
    one = placed(block(), name, "drive")
    (parameter,) = one.parameters
    model, z = block().with_effect(one), np.array([[0.3 * parameter.high]])
    both = np.stack([COMMANDS, COMMANDS[::-1]])[:, None]
    apart = [model.command(z, "drive", series[None])[0] for series in both]
    np.testing.assert_array_equal(model.command(z, "drive", both), np.stack(apart))


def test_a_new_episode_begins_at_rest_and_leaves_the_other() -> None:
    filter_ = lag()
    played(filter_, COMMANDS[:3])
    filter_.rest(np.array([0]))
    after = played(filter_, COMMANDS[3:])
    np.testing.assert_array_equal(after[:, 0], played(lag(), COMMANDS[3:])[:, 0])
    np.testing.assert_array_equal(after[:, 1], played(lag(), COMMANDS)[3:, 1])


def test_a_recalled_filter_goes_on() -> None:
    filter_, other = lag(), lag()
    other.remember(filter_.memory)  # nothing yet
    played(filter_, COMMANDS[:3])
    other.remember(filter_.memory)
    np.testing.assert_array_equal(played(other, COMMANDS[3:]), played(filter_, COMMANDS[3:]))
