"""Swing-ups: rewards by hand, starts, ends, and what the policy sees."""

import numpy as np
import pytest
from settings import setting

from dr_lab.envs.episodes import Episodes
from dr_lab.envs.rewards import ExponentialReward, QuadraticReward, SharedReward

ERROR, ACTION = np.array([[0.5, -1.0, 2.0, 0.0], [0.0, 0.0, 0.0, 0.0]]), np.array([[2.0], [0.0]])


def episodes(name: str, *overrides: str) -> Episodes:
    return setting(name, *overrides).make(None, 2, 0, threads=1).episodes


def test_exponential_and_quadratic_rewards_by_hand() -> None:
    weights = {"error_weights": [1.0, 1.0, 0.02, 0.005], "action_weights": [0.004]}
    squares = 0.25 + 1.0 + 0.08 + 0.016
    np.testing.assert_allclose(ExponentialReward(**weights)(ERROR, ACTION), [np.exp(-squares), 1.0])
    np.testing.assert_allclose(QuadraticReward(**weights)(ERROR, ACTION), [-squares, 0.0])


def test_shared_reward_by_hand() -> None:
    weights, scales = [0.05, 0.9, 0.0, 0.0, 0.05], [2.0, np.pi, 1.0, 1.0, 8.0]
    free = SharedReward(weights=weights, scales=scales, limits=[1.0, np.inf, np.inf, np.inf, 8.0])
    expected = 0.05 * 0.75**2 + 0.9 * (1 - 1 / np.pi) ** 2 + 0.05 * 0.75**2
    np.testing.assert_allclose(free(ERROR, ACTION), [expected, 1.0])
    bound = SharedReward(weights=weights, scales=scales, limits=[0.5, np.inf, np.inf, np.inf, 8.0])
    np.testing.assert_allclose(bound(ERROR, ACTION), [0.0, 1.0])


@pytest.mark.parametrize("name", ["furuta", "cartpole"])
def test_upright_at_rest_earns_most_and_hanging_least(name: str) -> None:
    one = episodes(name)
    one.simulator.batch.bind("qpos")[:] = [[0.0, np.pi], [0.0, 0.0]]
    one.simulator.batch.bind("qvel")[:] = 0.0
    upright, hanging = one.step(np.zeros((2, 1))).reward
    highest = {"furuta": 1.0, "cartpole": 0.0}[name]
    lowest = {"furuta": np.exp(-(np.pi**2)), "cartpole": -0.5 * np.pi**2}[name]
    assert upright == pytest.approx(highest, abs=1e-3)
    assert hanging == pytest.approx(lowest, rel=1e-3)


def test_the_furuta_sees_angles_as_sine_and_cosine_and_starts_hanging() -> None:
    one = episodes("furuta")
    qpos, qvel = (one.simulator.batch.bind(key) for key in ("qpos", "qvel"))
    seen = np.stack([np.sin(qpos[:, 0]), np.cos(qpos[:, 0]), np.sin(qpos[:, 1]), np.cos(qpos[:, 1]), *qvel.T], axis=1)
    np.testing.assert_allclose(one.observation, seen)
    assert (np.abs(qpos) < np.deg2rad([2.0, 1.0])).all()


def test_voltage_is_cut_off_and_the_rail_ends() -> None:
    one = episodes("cartpole")
    one.simulator.batch.bind("qpos")[:] = [[0.0, np.pi], [0.3569, np.pi]]
    one.simulator.batch.bind("qvel")[:] = [[0.0, 0.0], [1.0, 0.0]]
    outcome = one.step(np.full((2, 1), 100.0))
    np.testing.assert_array_equal(one.simulator.batch.bind("ctrl"), 8.0)
    assert list(outcome.terminated) == [False, True]
    assert outcome.reward[1] < -3000.0


def test_rewards_and_models_are_options() -> None:
    assert isinstance(setting("furuta", "env/reward=furuta/shared").task.reward_of, SharedReward)  # pyright: ignore
    assert setting("furuta", "model@env.model=qube").model.name == "qube"
    exponential, quadratic = (
        setting("cartpole", f"env/reward=cartpole/{name}").task.reward_of  # pyright: ignore
        for name in ("exponential", "quadratic")
    )
    np.testing.assert_allclose(exponential(ERROR, ACTION), np.exp(quadratic(ERROR, ACTION)))


def test_the_rail_of_a_domain_ends_where_its_length_says() -> None:
    one = setting("cartpole_domains").make(None, 2, 0, threads=1).episodes
    space = one.space
    one.give_contexts(np.array([space.vector({"rail.length": length}) for length in (0.4, 0.6)]))
    one.begin(np.arange(2))
    one.simulator.batch.bind("qpos")[:] = [[0.2, 0.0], [0.2, 0.0]]  # limits 0.15 and 0.25 m
    one.simulator.batch.bind("qvel")[:] = 0.0
    assert list(one.step(np.zeros((2, 1))).terminated) == [True, False]


def test_a_pole_to_be_balanced_starts_upright_and_ends_where_it_leans_too_far() -> None:
    one = episodes("furuta_balance")
    qpos = one.simulator.batch.bind("qpos")
    assert (np.abs(qpos - [0.0, np.pi]) < [0.2, 0.1]).all()
    qpos[:] = [[0.0, 3 * np.pi + 0.49], [0.0, -np.pi - 0.51]]
    one.simulator.batch.bind("qvel")[:] = 0.0
    assert list(one.step(np.zeros((2, 1))).terminated) == [False, True]
