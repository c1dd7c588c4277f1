"""Slots that train are spread over the episode from the start; slots that evaluate play whole episodes."""

import numpy as np
import pytest
from playing import Uniform, actions
from settings import setting

from dr_lab.envs.context_slots import first_ages
from dr_lab.envs.episodes import Episodes, StepOutcome

LIMIT, SLOTS = 40, 8


def episodes(seed: int = 0, *, staggered: bool) -> Episodes:
    of = setting("half_cheetah", "env/context=half_cheetah/density", f"env.task.time_limit={LIMIT}")
    source = Uniform(of.space.low, of.space.high)
    return of.make(source, SLOTS, seed, threads=1, staggered=staggered).episodes


def played(one: Episodes, steps: int) -> list[StepOutcome]:
    outcomes = []
    for k in range(steps):
        outcomes.append(one.step(actions(one, k)))
        if outcomes[-1].done.any():
            one.begin(np.flatnonzero(outcomes[-1].done))
    return outcomes


def test_every_batch_sees_all_phases_and_contexts_change_evenly() -> None:
    one = episodes(staggered=True)
    played(one, LIMIT)
    ages = np.sort(one.state_dict()["steps"])
    gaps = np.diff(np.append(ages, ages[0] + LIMIT))
    assert gaps.max() <= 2 * LIMIT / SLOTS
    for _ in range(4):  # quarters of an episode, in each of which about a quarter of the contexts is renewed
        before = one.contexts
        played(one, LIMIT // 4)
        assert 1 <= (one.contexts != before).any(axis=1).sum() <= 3


def test_what_is_cut_early_is_cut_as_by_the_time_limit() -> None:
    one = episodes(staggered=True)
    cut = np.array([outcome.truncated for outcome in played(one, LIMIT)])
    np.testing.assert_array_equal(cut.argmax(axis=0), LIMIT - first_ages(SLOTS, LIMIT) - 1)
    assert not any(outcome.terminated.any() for outcome in played(one, LIMIT))


def test_an_evaluation_plays_whole_episodes() -> None:
    outcomes = played(episodes(staggered=False), LIMIT)
    assert not any(outcome.done.any() for outcome in outcomes[:-1])
    assert outcomes[-1].truncated.all()


@pytest.mark.parametrize("steps", [7, 31])
def test_staggered_slots_go_on_exactly(steps: int) -> None:
    one, other = episodes(staggered=True), episodes(seed=5, staggered=True)
    played(one, steps)
    other.load_state_dict(one.state_dict())
    for a, b in zip(played(one, LIMIT), played(other, LIMIT), strict=True):
        np.testing.assert_array_equal(a.observation, b.observation)
        np.testing.assert_array_equal(a.truncated, b.truncated)


@pytest.mark.parametrize(("slots", "limit"), [(64, 1000), (16, 1000), (5, 3), (1, 1)])
def test_ages_are_below_the_time_limit_and_even_in_every_share(slots: int, limit: int) -> None:
    ages = first_ages(slots, limit)
    assert ages.min() >= 0
    assert ages.max() < limit
    for share in np.split(ages, 4) if slots % 4 == 0 else ():
        assert abs(share.mean() / limit - 0.5) < 0.2
