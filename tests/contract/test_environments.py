"""What every environment keeps: gymnasium's physics, resets that touch nothing else, an exact state."""

from typing import Any

import numpy as np
import pytest
from gymnasium_twins import twin
from playing import Uniform, actions, begun, played
from settings import setting
from torchrl.envs.utils import check_env_specs

from dr_lab.cli.folders import shipped
from dr_lab.cli.groups import options

NAMES = sorted(options("env", (shipped(),)))
MUJOCO = [name for name in NAMES if name not in ("lunar_lander", "nav2d")]
GYMNASIUM: dict[str, dict[str, Any]] = {
    "hopper": {"id": "Hopper-v5"},
    "half_cheetah": {"id": "HalfCheetah-v5"},
    "ant": {"id": "Ant-v5"},
    "ant_without_contacts": {"id": "Ant-v5", "include_cfrc_ext_in_observation": False, "contact_cost_weight": 0.0},
    "humanoid": {"id": "Humanoid-v5"},
}
LSDR = [
    f"{machine}/{context}"
    for machine in ("hopper", "half_cheetah")
    for context in ("torso_size", "density", "friction", "damping")
]
ALL_THREE = "env/context=[hopper/torso_size,hopper/friction,hopper/damping]"
BY_FIELD = "env/context=[hopper/friction,hopper/damping]"


@pytest.mark.parametrize("name", NAMES)
def test_torchrl_accepts_it(name: str) -> None:
    check_env_specs(setting(name).make(None, 2, 0, threads=1))


@pytest.mark.filterwarnings("ignore:compiler attribute 'settotalmass'")
@pytest.mark.parametrize("name", list(GYMNASIUM))
def test_steps_equal_gymnasium(name: str) -> None:
    episodes = begun(setting(name), slots=2)
    twins: list[Any] = [twin(**GYMNASIUM[name]) for _ in range(2)]
    state = {key: episodes.simulator.batch.bind(key) for key in ("qpos", "qvel")}

    def pair(slot: int) -> None:
        twins[slot].reset(seed=0)
        twins[slot].set_state(state["qpos"][slot].copy(), state["qvel"][slot].copy())
        np.testing.assert_allclose(episodes.observation[slot], twins[slot]._get_obs(), atol=1e-9)

    ends, touched = 0, False
    for slot in range(2):
        pair(slot)
    for k in range(80):
        action = actions(episodes, k)
        outcome = episodes.step(action)
        for slot, one in enumerate(twins):
            observation, reward, terminated, _, _ = one.step(action[slot])
            np.testing.assert_allclose(outcome.observation[slot], observation, rtol=1e-9, atol=1e-9)
            assert outcome.reward[slot] == pytest.approx(reward, rel=1e-9, abs=1e-9)
            assert outcome.terminated[slot] == terminated
            touched |= one.data.cfrc_ext.any()
        if outcome.done.any():
            ends += 1
            episodes.begin(np.flatnonzero(outcome.done))
            for slot in np.flatnonzero(outcome.done):
                pair(int(slot))
    assert ends or name not in ("hopper", "humanoid")
    assert touched


def test_a_time_limit_truncates_and_a_fall_terminates() -> None:
    episodes = begun(setting("hopper", "env.task.time_limit=5"))
    outcomes = [episodes.step(np.zeros((3, 3))) for _ in range(5)]
    assert not any(o.done.any() for o in outcomes[:4])
    assert outcomes[4].truncated.all()
    assert not outcomes[4].terminated.any()
    episodes = begun(setting("hopper"))
    episodes.simulator.batch.bind("qpos")[1, 2] = 0.5
    assert list(episodes.step(np.zeros((3, 3))).terminated) == [False, True, False]


@pytest.mark.parametrize("context", [ALL_THREE, BY_FIELD], ids=["by_compilation", "by_field"])
def test_a_reset_touches_only_its_own_episodes(context: str) -> None:
    one, other = (begun(setting("hopper", context), random=True) for _ in range(2))
    for k in range(3):
        one.step(actions(one, k))
        other.step(actions(other, k))
    before = one.contexts
    one.begin(np.array([1]))
    np.testing.assert_array_equal(one.contexts[[0, 2]], before[[0, 2]])
    assert (one.contexts[1] != before[1]).all()
    a, b = one.step(actions(one)), other.step(actions(other))
    np.testing.assert_array_equal(a.observation[[0, 2]], b.observation[[0, 2]])
    np.testing.assert_array_equal(a.reward[[0, 2]], b.reward[[0, 2]])
    assert (a.observation[1] != b.observation[1]).any()


def test_a_slot_draws_the_same_whatever_the_others_do() -> None:
    few, many = (begun(setting("hopper", BY_FIELD), slots, random=True) for slots in (2, 3))
    np.testing.assert_array_equal(few.contexts, many.contexts[:2])
    many.begin(np.array([2, 1][::-1]))
    few.begin(np.array([1]))
    np.testing.assert_array_equal(few.observation, many.observation[:2])


@pytest.mark.parametrize("context", [ALL_THREE, BY_FIELD], ids=["by_compilation", "by_field"])
def test_nothing_adds_up_over_resets(context: str) -> None:
    of = setting("hopper", context)
    used, new = begun(of, random=True), begun(of)
    for _ in range(3):
        used.begin(np.arange(3))
    z = np.tile(0.9 * of.space.nominal + 0.1 * of.space.high, (3, 1))
    for episodes in (used, new):
        episodes.give_contexts(z)
        episodes.begin(np.arange(3))
    for name in ("qpos", "qvel", "qacc_warmstart"):
        used.simulator.batch.bind(name)[:] = new.simulator.batch.bind(name)
    np.testing.assert_array_equal(used.contexts, z)
    for k in range(5):
        np.testing.assert_array_equal(used.step(actions(used, k)).observation, new.step(actions(new, k)).observation)


@pytest.mark.parametrize("context", LSDR)
def test_every_parameter_changes_the_motion(context: str) -> None:
    of = setting(context.partition("/")[0], f"env/context={context}")
    episodes = begun(of, slots=2)
    z = np.array([0.5 * of.space.nominal + 0.5 * of.space.high, of.space.nominal])
    episodes.give_contexts(z)
    episodes.begin(np.arange(2))
    for name in ("qpos", "qvel"):
        episodes.simulator.batch.bind(name)[1] = episodes.simulator.batch.bind(name)[0]
    rng = np.random.default_rng(0)
    for _ in range(60):
        episodes.simulator.step(np.tile(rng.uniform(episodes.low, episodes.high), (2, 1)), of.task.frame_skip)
    assert not np.allclose(*episodes.simulator.batch.bind("qpos"), rtol=0, atol=1e-6)


def test_infeasible_contexts_end_with_the_declared_return_and_stop_nobody() -> None:
    of = setting("hopper", "env/context=hopper/torso_size", "env.infeasible_return=-7")
    episodes = begun(of)
    episodes.give_contexts(np.array([[0.05], [-0.02], [0.0]]))  # the latter two do not compile
    episodes.begin(np.arange(3))
    outcome = episodes.step(np.zeros((3, 3)))
    assert list(outcome.terminated) == [False, True, True]
    np.testing.assert_array_equal(outcome.reward[1:], -7.0)
    episodes.step(np.zeros((3, 3)))  # what has ended is not counted again
    assert episodes.infeasible == 2
    episodes.give_contexts(np.full((3, 1), 0.05))
    episodes.begin(np.array([1, 2]))
    assert not episodes.step(np.zeros((3, 3))).terminated.any()


def test_divergence_ends_with_the_declared_return_and_stops_nobody() -> None:
    episodes = begun(setting("hopper", "env.infeasible_return=0"))
    earned = episodes.step(np.zeros((3, 3))).reward
    before = episodes.observation
    episodes.simulator.batch.bind("qvel")[1, 0] = 1e12
    outcome = episodes.step(np.zeros((3, 3)))
    assert list(outcome.terminated) == [False, True, False]
    assert earned[1] + outcome.reward[1] == pytest.approx(0.0)
    np.testing.assert_array_equal(outcome.observation[1], before[1])
    assert np.isfinite(outcome.observation).all()


def test_nothing_is_seen_or_earned_of_a_state_that_runs_away() -> None:
    of = setting("half_cheetah", "env/context=half_cheetah/damping")
    episodes, rng = of.make(None, 4, 0, threads=1).episodes, np.random.default_rng(0)
    episodes.give_contexts(np.full((4, 1), -9.5))  # N·m·s/rad: it accelerates itself, step by step
    episodes.begin(np.arange(4))
    ended = np.zeros(4, bool)
    for _ in range(600):
        outcome = episodes.step(rng.uniform(episodes.low, episodes.high, (4, len(episodes.low))))
        assert (np.abs(outcome.observation) <= of.speed_limit).all()
        assert (np.abs(outcome.reward[~outcome.infeasible]) <= of.speed_limit).all()
        ended |= outcome.infeasible
        if outcome.done.any():
            episodes.begin(np.flatnonzero(outcome.done))
    assert ended.any()


def test_an_episode_that_ran_away_stays_ended_and_is_counted_once() -> None:
    episodes = begun(setting("hopper"))
    episodes.simulator.batch.bind("qvel")[1, 0] = 1e3
    assert list(episodes.step(np.zeros((3, 3))).infeasible) == [False, True, False]
    episodes.simulator.batch.bind("qvel")[1] = 0.0
    assert list(episodes.step(np.zeros((3, 3))).infeasible) == [False, True, False]
    assert episodes.infeasible == 1
    episodes.begin(np.array([1]))
    assert not episodes.step(np.zeros((3, 3))).infeasible.any()


def test_divergence_pays_nothing_where_all_rewards_are_negative() -> None:
    episodes = begun(setting("cartpole", "env.infeasible_return=0"))
    earned = episodes.step(np.zeros((3, 1))).reward
    assert (earned < 0.0).all()
    episodes.simulator.batch.bind("qvel")[1, 0] = 1e12
    outcome = episodes.step(np.zeros((3, 1)))
    assert list(outcome.terminated) == [False, True, False]
    assert outcome.reward[1] == 0.0


@pytest.mark.parametrize("name", MUJOCO)
def test_feasible_episodes_return_more_than_infeasible_ones(name: str) -> None:
    of = setting(name)
    episodes, rng = begun(of, slots=4), np.random.default_rng(0)
    going, returns = np.ones(4, bool), np.zeros(4)
    for _ in range(of.task.time_limit):
        push = np.where(rng.random((4, len(episodes.low))) < 0.5, episodes.low, episodes.high)
        push[0] = 0.0
        outcome = episodes.step(push)
        returns[going] += outcome.reward[going]
        going = going & ~outcome.done
        if not going.any():
            break
    assert (returns > of.infeasible_return).all()


@pytest.mark.parametrize("context", [ALL_THREE, BY_FIELD], ids=["by_compilation", "by_field"])
def test_resumed_equals_uninterrupted(context: str) -> None:
    of = setting("hopper", context)
    one, other = begun(of, random=True), begun(of, seed=5, random=True)
    played(one, 20)
    state = one.state_dict()
    expected = played(one, 30, seed=20)
    other.load_state_dict(state)
    np.testing.assert_array_equal(played(other, 30, seed=20), expected)
    np.testing.assert_array_equal(other.contexts, one.contexts)


def test_a_shown_context_is_scaled_to_its_bounds() -> None:
    of = setting("hopper", "env/context=hopper/friction", "env.show_context=true")
    episodes = begun(of, random=True)
    assert episodes.observation.shape == (3, 12)
    np.testing.assert_allclose(episodes.observation[:, 11], (episodes.contexts[:, 0] + 3.0) / 13.0)


def test_given_contexts_are_those_of_the_next_episodes_until_none_are_given() -> None:
    env = setting("hopper", BY_FIELD).make(Uniform(np.zeros(2), np.ones(2)), 2, 0, threads=1)
    z = np.array([[2.0, 0.0], [3.0, 1.0]])
    env.set_contexts(z)
    np.testing.assert_array_equal(env.reset()["context"], z.astype(np.float32))
    env.set_contexts(None)
    assert (env.reset()["context"].numpy() < 1.0).all()
