"""A driver step by step does what the whole series through it does, and forgets and remembers as told."""

import numpy as np
from effect_machines import block, placed

from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.law import Influence, Law, Moment
from dr_lab.trajectory import Array

COMMANDS = np.array([1.0, 3.0, 3.0, -2.0, 0.5, 0.5])
TAU = np.array([0.003, 0.02])  # s, one for each simulation


def lag() -> tuple[PlacedEffect, Law]:
    effect = placed(block(), "actuator_lag", "drive")
    (driver,) = effect.drivers({"actuator_lag@drive.tau": TAU}, block().nominal())
    return effect, driver


def played(driver: Law, commands: Array) -> Array:
    """Outputs (steps, 2) of two simulations under the same commands."""
    outputs = []
    for command in commands:
        zero = np.zeros((2, 1))
        influence = Influence(np.full((2, 1), command), zero, zero, zero)
        driver.act(Moment(0.002, np.zeros(2), zero, zero, zero, zero, zero), influence)
        outputs.append(influence.control[:, 0])
    return np.array(outputs)


def test_steps_are_the_series() -> None:
    effect, driver = lag()
    values = {"actuator_lag@drive.tau": TAU[:, None, None]}
    series = effect.command(values, "drive", COMMANDS[None, None], block().spec.option)
    np.testing.assert_allclose(played(driver, COMMANDS), series[:, 0].T, rtol=1e-12)


def test_a_new_episode_begins_at_rest_and_leaves_the_other() -> None:
    _, driver = lag()
    played(driver, COMMANDS[:3])
    driver.rest(np.array([0]))
    after = played(driver, COMMANDS[3:])
    _, fresh = lag()
    _, whole = lag()
    np.testing.assert_array_equal(after[:, 0], played(fresh, COMMANDS[3:])[:, 0])
    np.testing.assert_array_equal(after[:, 1], played(whole, COMMANDS)[3:, 1])


def test_a_recalled_driver_goes_on() -> None:
    (_, driver), (_, other) = lag(), lag()
    other.remember(driver.memory)  # nothing yet
    played(driver, COMMANDS[:3])
    other.remember(driver.memory)
    np.testing.assert_array_equal(played(other, COMMANDS[3:]), played(driver, COMMANDS[3:]))
