"""One simulator replays one thing after another as fresh ones do: other starts, other contexts, the same again."""

import numpy as np
import pytest
from effect_machines import NAMES, catalogue_effect, hanging, placed

from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.law import History, Influence, Law, Moment, MotionLaw
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

BEFORE, STEPS, COUNT = 30, 60, 3
ACTING = [
    name
    for name in NAMES
    if isinstance(catalogue_effect(name), ForceLaw) and "hinge" in catalogue_effect(name).sites(hanging().nominal())
]
FOLLOWING = ["presliding_friction", "lugre_friction", "hysteresis"]


def lawful(name: str) -> Model:
    return hanging().with_effect(placed(hanging(), name, "hinge"))


def history(seed: float) -> History:
    moved = np.sin(seed + 0.05 * np.arange(-BEFORE, 0.0))[None, :, None]
    return History(np.array([0.4]), moved, 3.0 * np.cos(7.0 * moved), 0.3 * moved)


def replayed(simulator: Simulator, z: Array, start: float, before: History) -> Array:
    controls = 0.5 * np.sin(0.1 * np.arange(STEPS))[None, :, None]
    starts = np.full((COUNT, 1, 1), start), np.full((COUNT, 1, 1), 2.0 * start)
    return simulator.replay(z, *starts, controls, controls[:, :1], before).qpos


def contexts(model: Model) -> list[Array]:
    """Contexts that move one parameter after another, and back again."""
    space = model.space
    found = [np.tile(space.from_unit(np.full((1, len(space.names)), 0.4)), (COUNT, 1))]
    for column in [*range(len(space.names)), *reversed(range(len(space.names)))]:
        unit = space.to_unit(found[-1])
        unit[1:, column] = np.where(unit[1:, column] > 0.5, 0.3, 0.6)
        found.append(space.from_unit(unit))
    return found


@pytest.mark.parametrize("name", ACTING)
def test_one_simulator_replays_as_fresh_ones_do(name: str) -> None:
    model = lawful(name)
    one, earlier, later = Simulator(model, COUNT, 1), history(0.0), history(1.0)
    for z in contexts(model):
        for start, before in ((0.1, earlier), (0.3, earlier), (0.3, later)):
            fresh = replayed(Simulator(model, COUNT, 1), z, start, before)
            np.testing.assert_array_equal(replayed(one, z, start, before), fresh)


@pytest.mark.parametrize("name", FOLLOWING)
def test_a_motion_is_followed_as_step_by_step(name: str) -> None:
    model = lawful(name)
    z = np.concatenate(contexts(model)[:2])
    compiled = [model.compile(row) for row in z]
    step, speeds = model.spec.option.timestep, np.random.default_rng(0).normal(size=(len(z), BEFORE, 1))
    (at_once,), (by_steps,) = (model.laws(z, compiled) for _ in range(2))
    assert isinstance(at_once, MotionLaw)
    at_once.follow(speeds, step)
    for k in range(BEFORE):
        seen(by_steps, speeds[:, k], step)
    assert np.ptp(by_steps.memory) > 0
    np.testing.assert_allclose(at_once.memory, by_steps.memory, rtol=0, atol=1e-12)


def seen(law: Law, speed: Array, step: float) -> None:
    """Let a law see one step."""
    none = [np.zeros_like(speed) for _ in range(8)]
    law.replay_history(Moment(step, none[0][:, 0], none[1], speed, *none[2:5]), Influence(*none[4:]))
