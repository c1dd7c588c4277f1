"""Lunar landers are gymnasium's, with engines of their own, whatever plays them and wherever they are resumed."""

from typing import Any, cast

import gymnasium
import hydra
import mujoco
import numpy as np
import pytest
import torch
from hydra.errors import InstantiationException
from playing import Uniform
from settings import composed

from dr_lab.collectors.shares import joined, shares
from dr_lab.envs.environment import Environment
from dr_lab.envs.lunar_lander import episodes as lander_episodes
from dr_lab.envs.lunar_lander.episodes import LanderEpisodes
from dr_lab.envs.lunar_lander.lander import Lander, original
from dr_lab.envs.setting import require_mujoco
from dr_lab.envs.slots import StepOutcome
from dr_lab.errors import ConfigError, DrLabError
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.training.recorded import record
from dr_lab.trajectory import Array

BOTH = "env/context=[lunar_lander/main_engine,lunar_lander/side_engine]"


@pytest.fixture(autouse=True)
def _few_landers_have_processes_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lander_episodes, "_LEAST", 8)


def environment(*overrides: str) -> Environment:
    return hydra.utils.instantiate(composed("env=lunar_lander", *overrides), _convert_="all")


def landers(
    *overrides: str, slots: int = 3, seed: int = 0, threads: int = 1, source: ContextSource | None = None
) -> LanderEpisodes:
    return cast(LanderEpisodes, environment(*overrides).make(source, slots, seed, threads).episodes)


def action(step: int, slots: int) -> Array:
    """Reaches beyond the bounds."""
    return np.random.default_rng(step).uniform(-1.2, 1.2, (slots, 2))


def played(episodes: LanderEpisodes, steps: int, begin: int = 0) -> list[StepOutcome]:
    found = []
    for step in range(begin, begin + steps):
        found.append(episodes.step(action(step, episodes.nsim)))
        if found[-1].done.any():
            episodes.begin(np.flatnonzero(found[-1].done))
    return found


def same(ones: list[StepOutcome], others: list[StepOutcome]) -> None:
    for one, other in zip(ones, others, strict=True):
        for key in ("observation", "reward", "terminated", "truncated"):
            np.testing.assert_array_equal(getattr(one, key), getattr(other, key))


def follow_gymnasium(episodes: LanderEpisodes, steps: int) -> tuple[int, int]:
    """Compare every step; gives the numbers of terminations and truncations."""
    twins: list[Any] = [gymnasium.make("LunarLander-v3", continuous=True) for _ in range(episodes.nsim)]

    def begin(slot: int) -> None:
        observation, _ = twins[slot].reset(seed=int(episodes.state_dict()["seeds"][slot]))
        np.testing.assert_array_equal(episodes.observation[slot], observation)

    for slot in range(episodes.nsim):
        begin(slot)
    ends = [0, 0]
    for step in range(steps):
        asked = action(step, episodes.nsim)
        outcome = episodes.step(asked)
        for slot, twin in enumerate(twins):
            observation, reward, *flags, _ = twin.step(asked[slot])
            np.testing.assert_array_equal(outcome.observation[slot], observation)
            assert (outcome.reward[slot], outcome.terminated[slot], outcome.truncated[slot]) == (reward, *flags)
            ends = [end + flag for end, flag in zip(ends, flags, strict=True)]
        if outcome.done.any():
            episodes.begin(np.flatnonzero(outcome.done))
            for slot in np.flatnonzero(outcome.done):
                begin(int(slot))
    return ends[0], ends[1]


@pytest.mark.filterwarnings("ignore:.*is not within the observation space")
def test_steps_equal_gymnasium() -> None:
    terminated, _ = follow_gymnasium(landers(), 300)
    assert terminated > 3


@pytest.mark.filterwarnings("ignore:.*is not within the observation space")
def test_powers_are_those_of_gymnasiums_module(monkeypatch: pytest.MonkeyPatch) -> None:
    episodes = landers(BOTH)
    episodes.give_contexts(np.tile([10.0, 1.5], (3, 1)))
    episodes.begin(np.arange(3))
    monkeypatch.setattr(original, "MAIN_ENGINE_POWER", 10.0)
    monkeypatch.setattr(original, "SIDE_ENGINE_POWER", 1.5)
    follow_gymnasium(episodes, 100)


def test_each_slot_has_engines_of_its_own() -> None:
    z = np.array([[8.0, 0.6], [13.0, 0.6], [20.0, 0.6]])
    together = landers(BOTH)
    together.give_contexts(z)
    together.begin(np.arange(3))
    outcomes = played(together, 40)
    for slot, alike in enumerate(z):
        alone = landers(BOTH)
        alone.give_contexts(np.tile(alike, (3, 1)))
        alone.begin(np.arange(3))
        for one, other in zip(outcomes, played(alone, 40), strict=True):
            np.testing.assert_array_equal(one.observation[slot], other.observation[slot])


def test_a_nominal_power_is_that_of_the_task() -> None:
    faulty, given = landers("env.task.side_engine_power=6.0"), landers("env/context=lunar_lander/side_engine")
    given.give_contexts(np.full((3, 1), 6.0))
    for episodes in (faulty, given):
        episodes.begin(np.arange(3))
    same(played(faulty, 30), played(given, 30))


def test_results_do_not_depend_on_the_number_of_processes() -> None:
    source = Uniform(np.array([8.0]), np.array([20.0]))
    varied = [
        landers("env/context=lunar_lander/main_engine", slots=25, threads=threads, source=source) for threads in (1, 3)
    ]
    assert [len(episodes._workers) for episodes in varied] == [0, 2]
    same(*(played(episodes, 150) for episodes in varied))
    for key in ("contexts", "proposals", "observation"):
        np.testing.assert_array_equal(*(getattr(episodes, key) for episodes in varied))
    for one, other in zip(*(episodes.state for episodes in varied), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("threads", [1, 2])
def test_resumed_equals_uninterrupted(threads: int) -> None:
    overrides = ("env/context=lunar_lander/main_engine", "env.show_context=true")
    source = Uniform(np.array([8.0]), np.array([20.0]))
    one = landers(*overrides, slots=16, source=source)
    other = landers(*overrides, slots=16, seed=5, threads=threads, source=source)
    played(other, 7)
    played(one, 110)
    state = one.state_dict()
    expected = played(one, 120, begin=110)
    other.load_state_dict(state)
    same(played(other, 120, begin=110), expected)
    np.testing.assert_array_equal(other.contexts, one.contexts)


def test_a_state_is_dealt_to_workers_and_put_together_again() -> None:
    one, other = landers(slots=4), landers(slots=4, seed=3)
    played(one, 50)
    other.load_state_dict(joined(shares(one.state_dict(), 4, 2), 4))
    same(played(one, 50, begin=50), played(other, 50, begin=50))


def test_what_has_ended_stays_as_it_is_until_it_begins_anew() -> None:
    waiting = landers()
    ended = np.zeros(3, bool)
    last = waiting.observation
    for step in range(150):
        outcome = waiting.step(action(step, 3))
        np.testing.assert_array_equal(outcome.observation[ended], last[ended])
        assert not outcome.reward[ended].any()
        assert outcome.done[ended].all()
        ended, last = outcome.done, outcome.observation
    assert ended.any()
    waiting.begin(np.flatnonzero(ended))
    assert not waiting.step(action(0, 3)).done.any()


def test_a_time_limit_truncates() -> None:
    outcomes = played(landers("env.task.time_limit=5"), 10)
    assert [outcome.truncated.all() for outcome in outcomes] == [step % 5 == 4 for step in range(10)]
    assert not any(outcome.terminated.any() for outcome in outcomes)


def test_slots_of_training_are_staggered() -> None:
    episodes = environment("env.task.time_limit=5").make(None, 3, 0, 1, staggered=True).episodes
    assert len({step for step in range(5) for cut in episodes.step(action(step, 3)).truncated if cut}) > 1


def test_a_recorded_episode_shows_what_the_policy_saw() -> None:
    of = environment("env/context=lunar_lander/main_engine")
    seen = list[torch.Tensor]()

    def fall(observation: torch.Tensor) -> torch.Tensor:
        seen.append(observation)
        return torch.zeros(len(observation), 2)

    (episode,) = record(of, of.make(None, 1, 0, 1).episodes, fall, np.array([[10.0]]))
    assert episode.ended == "terminated"
    assert episode.context == {"main_engine_power": (10.0, "N·s/m")}
    assert episode.time[1] == pytest.approx(0.02)
    observation = torch.cat(seen).double().numpy()
    # 10 m half a viewport, 20/3 m half its height; the observation's height is that of feet 0.6 m below the hull
    np.testing.assert_allclose(episode.qpos[:-1, 0], 10.0 * observation[:, 0], atol=1e-5)
    np.testing.assert_allclose(episode.qpos[:-1, 1] - 0.6, 20.0 / 3.0 * observation[:, 1], atol=1e-5)
    np.testing.assert_allclose(episode.qpos[:-1, 2], observation[:, 4], atol=1e-5)
    np.testing.assert_allclose(episode.qvel[:-1, 0], 5.0 * observation[:, 2], atol=1e-5)


def test_the_scene_has_the_legs_where_box2d_has_them() -> None:
    lander, scene = Lander(), environment().scene(np.empty(0))
    lander.begin(3, np.array([13.0, 0.6]))
    data = mujoco.MjData(scene)
    for step in range(60):
        lander.step(action(step, 1)[0])
        position, _ = lander.state
        data.qpos[:] = position
        mujoco.mj_kinematics(scene, data)
        assert position[2] != 0.0
        for leg, strut in zip(lander.legs, ("right_strut", "left_strut"), strict=True):
            middle = [leg.position.x - 10.0, 0.0, leg.position.y - lander.helipad_y]
            np.testing.assert_allclose(data.geom(strut).xpos, middle, atol=0.03)  # Box2D's joints give way a little


def test_what_box2d_cannot_do_is_said() -> None:
    of = environment()
    with pytest.raises(ConfigError, match=r"evaluator=real_vs_sim .* env=lunar_lander is played by another engine"):
        require_mujoco(of, "evaluator=real_vs_sim")
    with pytest.raises(ConfigError, match="starts cannot be given"):
        landers().begin(np.arange(3), (np.zeros((3, 5)), np.zeros((3, 5))))
    with pytest.raises(InstantiationException, match="no parameter 'gravity' in the lunar lander"):
        environment("+env.parameters={gravity:{unit:m,low:1.0,high:2.0}}")


def test_the_end_of_a_process_is_told() -> None:
    episodes = landers(slots=16, threads=2)
    (worker,) = episodes._workers
    worker._process.kill()
    worker._process.wait()
    with pytest.raises(DrLabError, match="A process that plays landers has ended, with exit code -9"):
        episodes.step(np.zeros((16, 2)))


def test_after_an_error_no_answer_is_taken_for_that_of_a_later_call() -> None:
    after, without = (landers(slots=24, threads=3) for _ in range(2))
    for wrong in range(3):
        with pytest.raises(TypeError, match="positional argument"):
            after._ask("state", [("more",) if process == wrong else () for process in range(3)])
    same(played(after, 5), played(without, 5))


def test_an_error_in_a_process_is_raised_here() -> None:
    (worker,) = landers(slots=16, threads=2)._workers
    worker.ask("step", np.array([99]), np.zeros((1, 2)))
    with pytest.raises(IndexError):
        worker.answer()
