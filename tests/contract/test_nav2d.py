"""A point in the plane moves as it is told: closed forms, all collectors, exact continuation, no sight of the goal."""

from collections.abc import Sequence

import hydra
import mujoco
import numpy as np
import pytest
import torch
from hydra.errors import InstantiationException
from settings import composed
from torch import Tensor

from dr_lab.collectors.collector import Collector
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.lean import LeanCollector
from dr_lab.collectors.play import undiscounted
from dr_lab.collectors.shares import joined, shares
from dr_lab.collectors.torchrl import TorchRLCollector
from dr_lab.envs.environment import Environment
from dr_lab.envs.slots import EpisodeSlots
from dr_lab.randomizers.uniform import UniformRandomizer
from dr_lab.training.recorded import record
from dr_lab.trajectory import Array

LIMIT, STRIDE = 100, 0.1


def nav2d(*overrides: str) -> Environment:
    return hydra.utils.instantiate(composed("env=nav2d", *overrides), _convert_="all")


def points(goals: Sequence[Sequence[float]], *overrides: str) -> EpisodeSlots:
    """Episodes with these goals."""
    made = nav2d(*overrides).make(None, len(goals), 0).episodes
    made.give_contexts(np.array(goals))
    made.begin(np.arange(len(goals)))
    return made


def drawn(slots: int, seed: int = 0, *, staggered: bool = False) -> EpisodeSlots:
    of = nav2d("env.task.time_limit=12")
    return of.make(UniformRandomizer(of.space, {}), slots, seed, staggered=staggered).episodes


def walked(episodes: EpisodeSlots, steps: int, seed: int = 0) -> Array:
    """Places and rewards of a random walk, shape (steps, n, 3)."""
    rng, found = np.random.default_rng(seed), []
    for _ in range(steps):
        outcome = episodes.step(rng.uniform(-0.2, 0.2, (episodes.nsim, 2)))
        found.append(np.column_stack([outcome.observation, outcome.reward]))
        if outcome.done.any():
            episodes.begin(np.flatnonzero(outcome.done))
    return np.array(found)


def right(observation: Tensor) -> Tensor:
    return torch.tensor([1.0, 0.0]).expand(len(observation), 2)


def test_a_step_is_cut_off_and_the_distance_after_it_costs() -> None:
    made = points([[0.3, 0.4], [-0.5, 0.1]])
    first = made.step(np.array([[0.03, -0.04], [-2.0, 5.0]]))
    np.testing.assert_allclose(first.observation, [[0.03, -0.04], [-STRIDE, STRIDE]])
    np.testing.assert_allclose(first.reward, [-np.hypot(0.27, 0.44), -0.4])
    second = made.step(np.zeros((2, 2)))
    np.testing.assert_array_equal(second.observation, first.observation)
    np.testing.assert_array_equal(second.reward, first.reward)
    np.testing.assert_allclose(made.step(np.full((2, 2), 1.0)).observation, [[0.13, 0.06], [0.0, 0.2]])


def test_it_ends_where_both_coordinates_are_near_or_with_the_time() -> None:
    made, act = points([[0.1, 0.1], [0.1, 0.1], [0.1, 0.1]]), np.array([[0.091, 0.109], [0.1, 0.089], [0.0, 0.1]])
    outcome = made.step(act)
    assert outcome.terminated.tolist() == [True, False, False]
    ends = [made.step(np.zeros((3, 2))) for _ in range(LIMIT - 1)]
    assert not any(each.truncated.any() for each in ends[:-1])
    assert ends[-1].truncated.all()
    assert not outcome.infeasible.any()
    never = points([[0.1, 0.0]], "env.task.reached=0")
    assert not never.step(np.array([[0.1, 0.0]])).terminated.any()


def test_the_goal_is_not_seen_unless_it_is_shown() -> None:
    assert points([[0.3, -0.2]]).observation.tolist() == [[0.0, 0.0]]
    shown = points([[0.3, -0.2]], "env.show_context=true", "env.goal_range=2")
    np.testing.assert_allclose(shown.observation, [[0.0, 0.0, 2.3 / 4, 1.8 / 4]])


def test_episodes_begin_where_they_are_told_and_others_go_on() -> None:
    made = points([[0.5, 0.5]] * 3)
    made.step(np.full((3, 2), 0.1))
    made.begin(np.array([1]), (np.array([[0.2, -0.3]]), np.array([[1.0, 0.0]])))
    place, velocity = made.state
    np.testing.assert_allclose(place, [[0.1, 0.1], [0.2, -0.3], [0.1, 0.1]])
    np.testing.assert_allclose(velocity, [[1.0, 1.0], [1.0, 0.0], [1.0, 1.0]])


@pytest.mark.parametrize("kind", [LeanCollector, TorchRLCollector])
def test_training_collects_and_plays_it(kind: type[LeanCollector | TorchRLCollector]) -> None:
    of = nav2d("env.task.time_limit=12")
    env = of.make(UniformRandomizer(of.space, {}), 3, 0)
    collector: Collector = kind(env, right, 30)
    experience = Experience(collector, right, of.make(None, 2, 1).episodes)
    batch = experience.collect()
    steps = np.tile(np.arange(1, 13), 3)[:30] * STRIDE
    goal = batch["context"].double()
    away = torch.hypot(torch.from_numpy(steps) - goal[..., 0], goal[..., 1])
    torch.testing.assert_close(-batch["next", "reward"][..., 0].double(), away, atol=1e-6, rtol=0)
    assert batch["next", "truncated"][0, :, 0].nonzero().flatten().tolist() == [11, 23]
    played = experience.play(right, np.array([[0.5, 0.0], [0.2, 0.0], [0.0, 0.5]]))
    assert played["mask"].sum(1).tolist() == [5, 2, 12]  # pyright: ignore[reportOptionalMemberAccess]
    assert undiscounted(played)[1] == pytest.approx(-0.1)
    experience.close()


def test_resumed_equals_uninterrupted_also_when_dealt_to_workers() -> None:
    one = drawn(4)
    walked(one, 17)
    state = one.state_dict()
    expected = walked(one, 40, seed=1)
    for other, given in ((drawn(4, seed=5), state), (drawn(4, seed=6), joined(shares(state, 4, 2), 4))):
        other.load_state_dict(given)
        np.testing.assert_array_equal(walked(other, 40, seed=1), expected)
        np.testing.assert_array_equal(other.contexts, one.contexts)


def test_a_slot_draws_the_same_whatever_the_others_do() -> None:
    few, many = drawn(2), drawn(5)
    np.testing.assert_array_equal(many.contexts[:2], few.contexts)
    assert len(np.unique(many.contexts[:, 0])) == 5


def test_what_was_handed_out_stays() -> None:
    made = points([[0.5, 0.5]] * 2)
    first = made.step(np.full((2, 2), 0.05))
    kept = first.observation.copy()
    made.step(np.full((2, 2), 0.05))
    made.begin(np.array([0]))
    np.testing.assert_array_equal(first.observation, kept)


def test_slots_of_training_are_staggered() -> None:
    episodes = drawn(5, staggered=True)
    cut = [int(episodes.step(np.zeros((5, 2))).truncated.sum()) for _ in range(12)]
    assert cut[-1] == 5
    assert max(np.diff(cut)) == 1


def test_a_recorded_episode_shows_the_goal_where_the_context_has_it() -> None:
    of = nav2d()
    (episode,) = record(of, of.make(None, 1, 0).episodes, right, np.array([[0.3, 0.0]]))
    assert episode.ended == "terminated"
    assert episode.context == {"goal.x": (0.3, "m"), "goal.y": (0.0, "m")}
    np.testing.assert_allclose(episode.qpos[:, 0], [0.0, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(episode.qvel[:, 0], [0.0, 1.0, 1.0, 1.0])  # m/s, a step of 0.1 m in 0.1 s
    data = mujoco.MjData(episode.geometry)
    data.qpos[:] = episode.qpos[-1]
    mujoco.mj_kinematics(episode.geometry, data)
    np.testing.assert_allclose(data.body("point").xpos[:2], data.body("goal").xpos[:2], atol=1e-12)


def test_numbers_out_of_their_range_are_refused() -> None:
    for override, told in (
        ("env.goal_range=0", r"env\.goal_range is 0; expected a number above 0"),
        ("env.task.stride=-1", r"env\.task\.stride is -1; expected a number above 0"),
    ):
        with pytest.raises(InstantiationException, match=told):
            nav2d(override)
