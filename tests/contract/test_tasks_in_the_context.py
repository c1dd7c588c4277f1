"""Machines of gymnasium that are asked for something else in every episode: its physics, the sources' rewards."""

from typing import Any

import numpy as np
import pytest
from gymnasium_twins import twin
from hydra.errors import InstantiationException
from settings import setting

from dr_lab.envs.episodes import Episodes
from dr_lab.trajectory import Array

ANTS = ["ant_velocity", "ant_navigation"]
ASKED = {
    "ant_velocity": [[0.0], [1.0], [3.0]],
    "ant_navigation": [[0.0, 0.0], [3.0, -1.0], [-2.0, 0.5]],
    "humanoid_direction": [[0.0], [2.0], [5.0]],
}


def asked(name: str) -> Episodes:
    """Episodes, one for each of the things asked for, all from the same state."""
    made = setting(name).make(None, 3, 0, threads=1).episodes
    made.give_contexts(np.array(ASKED[name]))
    made.begin(np.arange(3))
    qpos, qvel = made.state
    made.begin(np.arange(3), (np.tile(qpos[0], (3, 1)), np.tile(qvel[0], (3, 1))))
    return made


def beside(name: str, made: Episodes) -> Any:  # noqa: ANN401 (gymnasium's)
    """Gymnasium's machine in the state of the first episode."""
    options = {"id": "Ant-v5" if name in ANTS else "Humanoid-v5", "exclude_current_positions_from_observation": False}
    found: Any = twin(**options)
    found.reset(seed=0)
    qpos, qvel = made.state
    found.set_state(qpos[0], qvel[0])
    return found


def wanted(name: str, one: Any, action: Array, info: dict[str, float]) -> Array:  # noqa: ANN401 (gymnasium's)
    """Rewards of the three by what gymnasium's machine has done, as the sources write them down."""
    z = np.array(ASKED[name])
    if name == "humanoid_direction":
        along = info["x_velocity"] * np.cos(z[:, 0]) + info["y_velocity"] * np.sin(z[:, 0])
        return 1.25 * along + 5.0 + info["reward_ctrl"] + info["reward_contact"]
    costs = 0.005 * np.square(action).sum() - info["reward_contact"]
    if name == "ant_velocity":
        return 1.0 - np.abs(info["x_velocity"] - z[:, 0]) + 0.05 - costs
    return 4.0 - np.abs(one.data.body("torso").xpos[:2] - z).sum(1) + 0.05 - costs


@pytest.mark.parametrize("name", list(ASKED))
def test_the_machine_is_gymnasiums_and_the_reward_follows_its_formula(name: str) -> None:
    made = asked(name)
    one, rng, touched, ended = beside(name, made), np.random.default_rng(0), False, False
    for _ in range(60):
        action = rng.uniform(made.low, made.high)
        outcome = made.step(np.tile(action, (3, 1)))
        observation, _, terminated, _, info = one.step(action)
        np.testing.assert_allclose(outcome.reward, wanted(name, one, action, info), rtol=1e-9, atol=1e-9)
        np.testing.assert_array_equal(outcome.terminated, terminated)
        seen = observation if name in ANTS else observation[2:]
        np.testing.assert_allclose(outcome.observation[0][: len(seen)], seen, rtol=1e-9, atol=1e-9)
        np.testing.assert_array_equal(outcome.observation[1:], outcome.observation[[0, 0]])  # the task is not seen
        touched |= info["reward_contact"] < 0.0
        ended |= terminated
        if terminated:
            break
    assert touched
    assert ended or name in ANTS  # what the last step earns is compared, too


@pytest.mark.parametrize("name", ANTS)
def test_ants_see_their_torso(name: str) -> None:
    made = asked(name)
    made.step(np.zeros((3, 8)))
    matrix, place = made.observation[0, 107:116].reshape(3, 3), made.observation[0, 116:]
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-9)
    np.testing.assert_allclose(place, made.observation[0, :3], atol=0.05)  # an evaluation of the integrator older


@pytest.mark.parametrize("name", list(ASKED))
def test_the_task_changes_no_physics(name: str) -> None:
    made = asked(name)
    for step in range(20):
        rewards = made.step(np.tile(np.random.default_rng(step).uniform(made.low, made.high), (3, 1))).reward
    qpos, qvel = made.state
    np.testing.assert_array_equal(qpos[1:], qpos[[0, 0]])
    np.testing.assert_array_equal(qvel[1:], qvel[[0, 0]])
    assert len(np.unique(rewards)) == 3  # pyright: ignore[reportPossiblyUnboundVariable]


def test_straight_ahead_the_humanoid_is_gymnasiums_until_it_falls() -> None:
    plain, turned = (
        setting(name, "env.task.time_limit=200").make(None, 1, 0, threads=1).episodes
        for name in ("humanoid", "humanoid_direction")
    )
    np.testing.assert_array_equal(plain.observation, turned.observation)
    for step in range(15):
        action = np.random.default_rng(step).uniform(plain.low, plain.high, (1, 17))
        one, other = plain.step(action), turned.step(action)
        np.testing.assert_array_equal(one.observation, other.observation)
        np.testing.assert_allclose(other.reward, one.reward, rtol=1e-12)


def test_ranges_that_are_none_are_refused() -> None:
    for name, override, told in (
        ("ant_velocity", "env.task.velocity_range=[3,0]", r"env\.task\.velocity_range is \[3, 0\] m/s; expected"),
        ("humanoid_direction", "env.task.direction_range=[1]", r"env\.task\.direction_range is \[1\] rad; expected"),
        ("ant_navigation", "env.task.goal_range=-1", r"env\.task\.goal_range is -1; expected a number above 0"),
    ):
        with pytest.raises(InstantiationException, match=told):
            setting(name, override)
