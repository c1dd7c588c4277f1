"""Simulations with laws between steps: given new contexts, stopped and gone on with."""

from collections.abc import Sequence

import numpy as np
import pytest
from effect_machines import hanging, placed

from dr_lab.physics.model import Model
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

COMMAND = 0.8  # N·m


LAWS = [("load_dependent_friction", "hysteresis"), ("joint_elasticity",), ("motor_side_elasticity",), ("backlash",)]


def lawful(effects: Sequence[str] = LAWS[0]) -> Model:
    model = hanging()
    for effect in effects:
        model = model.with_effect(placed(hanging(), effect, "hinge"))
    return model


def contexts(model: Model) -> Array:
    return np.tile(0.5 * (model.space.low + model.space.high), (2, 1))


def moved(simulator: Simulator, nstep: int = 100) -> Array:
    simulator.step(np.full((simulator.nsim, simulator.compiled.nu), COMMAND), nstep)
    return simulator.batch.bind("qpos").copy()


def test_friction_of_laws_does_not_add_up_over_contexts() -> None:
    model = lawful()
    ends = []
    simulator = Simulator(model, 2)
    for _ in range(3):
        simulator.set_contexts(contexts(model))
        simulator.reset()
        ends.append(moved(simulator))
    np.testing.assert_array_equal(ends[0], ends[1])
    np.testing.assert_array_equal(ends[0], ends[2])


@pytest.mark.parametrize("effects", LAWS)
def test_a_new_context_leaves_what_the_others_remember(effects: Sequence[str]) -> None:
    model = lawful(effects)
    one, other = Simulator(model, 2), Simulator(model, 2)
    for simulator in (one, other):
        simulator.set_contexts(contexts(model))
        moved(simulator)
    one.set_contexts(contexts(model)[:1], np.array([0]))
    one.reset(np.array([0]))
    np.testing.assert_array_equal(moved(one)[1], moved(other)[1])


@pytest.mark.parametrize("effects", LAWS)
def test_contexts_given_one_by_one_are_those_given_at_once(effects: Sequence[str]) -> None:
    model = lawful(effects)
    z = model.space.low + np.array([[0.3], [0.7]]) * (model.space.high - model.space.low)
    one, other = Simulator(model, 2), Simulator(model, 2)
    one.set_contexts(z[::-1])
    moved(one)
    for row in range(2):
        one.set_contexts(z[[row]], np.array([row]))
    one.reset()
    other.set_contexts(z)
    other.reset()
    np.testing.assert_array_equal(moved(one), moved(other))


@pytest.mark.parametrize("effects", LAWS)
def test_recalled_simulations_go_on_as_if_never_stopped(effects: Sequence[str]) -> None:
    model = lawful(effects)
    one, other = Simulator(model, 2), Simulator(model, 2)
    one.set_contexts(contexts(model))
    other.set_contexts(contexts(model))
    moved(one)
    memory = one.memory
    expected = moved(one)
    other.restore(memory)
    np.testing.assert_array_equal(moved(other), expected)
