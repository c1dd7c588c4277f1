"""EPOpt keeps the episodes that went worst, by hand."""

import pytest
import torch
from torch import Tensor

from dr_lab.algorithms.epopt.worst_episodes import WorstEpisodes
from dr_lab.errors import ConfigError

NOTHING = torch.zeros(2, 4)
NEVER = torch.zeros(2, 4, dtype=torch.bool)


def flags(*rows: list[int]) -> Tensor:
    return torch.tensor(rows, dtype=torch.bool)


def test_keeps_the_steps_of_the_worst_episodes() -> None:
    select = WorstEpisodes(gamma=1.0, epsilon=0.5, warm_up=0)
    reward = torch.tensor([[1.0, 1.0, 5.0, 5.0], [0.0, 1.0, 1.0, 9.0]])
    done = flags([0, 1, 0, 1], [0, 0, 1, 1])
    # Returns 2, 10 and 2, 9: the worst half are both of 2.
    expected = flags([1, 1, 0, 0], [1, 1, 1, 0])
    assert torch.equal(select(reward, done, NEVER, NOTHING), expected)


def test_an_episode_that_goes_on_counts_with_its_past_and_its_value() -> None:
    select = WorstEpisodes(gamma=0.5, epsilon=0.5, warm_up=0)
    select(torch.full((2, 1), 4.0), flags([0], [1]), NEVER[:, :1], NOTHING[:, :1])
    reward, done = torch.tensor([[2.0, 2.0], [3.0, 3.0]]), flags([0, 1], [0, 0])
    next_value = torch.tensor([[9.0, 9.0], [0.0, 3.0]])
    # First 4 + 2/2 + 2/4 = 5.5, ended; second, new, 3 + 3/2 + 3/4 = 5.25 with its value.
    assert torch.equal(select(reward, done, NEVER[:, :2], next_value), flags([0, 0], [1, 1]))


def test_everything_is_kept_while_it_warms_up_and_where_epsilon_is_one() -> None:
    reward, done = torch.tensor([[1.0, 2.0, 3.0, 4.0]]), flags([1, 1, 1, 1])
    warming = WorstEpisodes(gamma=1.0, epsilon=0.25, warm_up=1)
    assert warming(reward, done, NEVER[:1], NOTHING[:1]).all()
    assert torch.equal(warming(reward, done, NEVER[:1], NOTHING[:1]), flags([1, 0, 0, 0]))
    assert WorstEpisodes(gamma=1.0, epsilon=1.0, warm_up=0)(reward, done, NEVER[:1], NOTHING[:1]).all()


def test_infeasible_episodes_are_neither_ranked_nor_learnt_from() -> None:
    select = WorstEpisodes(gamma=1.0, epsilon=0.5, warm_up=0)
    reward = torch.tensor([[-9.0, -9.0, 3.0, 3.0], [1.0, -9.0, 1.0, 1.0]])
    done, infeasible = flags([1, 1, 0, 1], [0, 1, 0, 0]), flags([1, 1, 0, 0], [0, 1, 0, 0])
    # Feasible are 6 and 2 alone; the second slot's first episode diverged in its second step.
    assert torch.equal(select(reward, done, infeasible, NOTHING), flags([0, 0, 0, 0], [0, 0, 1, 1]))
    warming = WorstEpisodes(gamma=1.0, epsilon=0.5, warm_up=1)
    assert torch.equal(warming(reward, done, infeasible, NOTHING), flags([0, 0, 1, 1], [0, 0, 1, 1]))
    everywhere = torch.ones_like(done)
    assert not select(reward, everywhere, everywhere, NOTHING).any()


def test_continues_exactly() -> None:
    first = WorstEpisodes(gamma=0.5, epsilon=0.5, warm_up=0)
    reward, done = torch.tensor([[1.0], [2.0]]), flags([0], [0])
    first(reward, done, NEVER[:, :1], NOTHING[:, :1])
    second = WorstEpisodes(gamma=0.5, epsilon=0.5, warm_up=0)
    second.load_state_dict(first.state_dict())
    more = torch.tensor([[1.6], [0.0]])
    # 1 + 1.6/2 = 1.8 against 2; without the past 1.6 against 0.
    for select in (first, second):
        assert torch.equal(select(more, flags([1], [1]), NEVER[:, :1], NOTHING[:, :1]), flags([1], [0]))


def test_new_episodes_have_no_past() -> None:
    select = WorstEpisodes(gamma=0.5, epsilon=0.5, warm_up=0)
    select(torch.tensor([[1.0], [2.0]]), flags([0], [0]), NEVER[:, :1], NOTHING[:, :1])
    select.forget_episodes()
    # 1.6 against 0; with the past 1 + 1.6/2 = 1.8 against 2.
    more = torch.tensor([[1.6], [0.0]])
    assert torch.equal(select(more, flags([1], [1]), NEVER[:, :1], NOTHING[:, :1]), flags([0], [1]))


def test_a_share_beyond_one_is_told() -> None:
    with pytest.raises(ConfigError, match="share in"):
        WorstEpisodes(gamma=1.0, epsilon=1.5, warm_up=0)
