"""A filter step by step does what the whole series through it does, and forgets and remembers as told."""

import numpy as np
import pytest
from effect_machines import block, catalogue_effect, placed

from dr_lab.physics.effect_parts import StepwiseFilter
from dr_lab.physics.law import History, Influence, Law, Moment
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

COMMANDS = np.array([1.0, 3.0, 3.0, -2.0, 0.5, 0.5])
STEP = 0.002
TAU = np.array([0.003, 0.02])  # s, one for each simulation
BEFORE, AFTER = 90, 40  # steps that were measured, and that are simulated


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


@pytest.mark.parametrize("known", [20, BEFORE, BEFORE + 60])
@pytest.mark.parametrize("name", ["actuator_lag", "rate_limit", "dead_zone"])
def test_laws_have_seen_commands_behind_the_filter(name: str, known: int) -> None:
    """In each context and window their own, from the first one that is known on."""
    bare = block().with_effect(placed(block(), "joint_elasticity", "rail"))
    model = bare.with_effect(placed(block(), name, "drive"))
    behind = np.tile(bare.space.low + 0.4 * (bare.space.high - bare.space.low), (2, 1))
    (filtering,) = model.effects[1].parameters
    z = np.column_stack([behind, np.array([0.2, 0.7]) * filtering.high])
    moments = np.arange(-max(known, BEFORE), AFTER)
    commands = np.stack([np.sign(np.sin(0.05 * moments + shift)) for shift in (0.3, 1.5)])[..., None]
    found = seen(model, z, commands, known)
    arrived = model.command(z, "drive", commands[None, ..., 0])[..., None]
    for k in range(2):
        expected = seen(bare, behind[:1], arrived[k], known)[0]
        np.testing.assert_allclose(found[k], expected, rtol=0, atol=1e-12)
    assert np.abs(found[0] - found[1]).max() > 1e-6


@pytest.mark.parametrize("name", ["joint_elasticity", "motor_side_elasticity", "backlash"])
def test_commands_are_bounded_before_a_motor_sees_them(name: str) -> None:
    """In whichever order the effects are added."""
    commands = np.sign(np.sin(0.05 * np.arange(-BEFORE, AFTER)))[None, :, None]
    motor, bound = placed(block(), name, "rail"), placed(block(), "torque_speed_limit", "drive")
    found = []
    for order in ((bound, motor), (motor, bound)):
        model = block().with_effect(order[0]).with_effect(order[1])
        middle = model.space.mapping(0.6 * model.space.low + 0.4 * model.space.high)
        values = middle | {f"{bound.label}.inverse_stall": 2.0, f"{bound.label}.inverse_speed": 0.2}
        found.append(seen(model, model.space.vector(values)[None], commands, BEFORE))
    np.testing.assert_array_equal(*found)


def seen(model: Model, z: Array, commands: Array, known: int) -> Array:
    """Positions in windows whose commands and motion before were seen, shape (c, w, s + 1)."""
    windows, start = len(commands), commands.shape[1] - AFTER
    shape = len(z), windows, 1
    before, moved = commands[:, start - BEFORE : start], 0.1 * np.ones((windows, BEFORE, 1))
    history = History(np.zeros(windows), moved, np.cos(moved * np.arange(BEFORE)[:, None]), before)
    past, coming = commands[:, start - known : start], commands[:, start:]
    simulator = Simulator(model, len(z) * windows, threads=1)
    rollout = simulator.replay(z, np.zeros(shape), np.zeros(shape), coming, past, history)
    return rollout.qpos.reshape(*shape[:2], -1)
