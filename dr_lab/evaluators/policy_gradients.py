"""Whole episodes of a stochastic policy in a context, to take its gradient or its curvature from."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import torch
from torch import Tensor

from dr_lab.algorithms.reinforce.baseline import Baseline
from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes, whole_episodes
from dr_lab.collectors.collector import Policy
from dr_lab.collectors.play import play
from dr_lab.envs.slots import EpisodeSlots
from dr_lab.errors import ConfigError
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.trajectory import Array

_Thing = TypeVar("_Thing")


@dataclass(frozen=True)
class PlayedEpisodes:
    """What a policy played and how well it went.

    Attributes:
        episodes: the feasible ones, float64.
        advantage: G_t − b_t of every step, shape (k, t).
        returns: G_0, discounted, shape (k,).
    """

    episodes: WholeEpisodes
    advantage: Tensor
    returns: Tensor


def played(slots: EpisodeSlots, actor: GaussianActor, z: Array, baseline: Baseline, gamma: float) -> PlayedEpisodes:
    """Play one episode in each context.

    Args:
        slots: that run side by side.
        actor: acts, with exploration.
        z: contexts, shape (k, n); episodes in all of them share one baseline.
        baseline: what is taken off the returns-to-go.
        gamma: discount per control step.

    Raises:
        ConfigError: the baseline has to learn first.
    """
    if baseline.learns:
        raise ConfigError(
            f"evaluator.baseline is {type(baseline).__name__}, which is 0 until it has learnt from earlier batches, "
            "of which an evaluator has none. Give baseline@evaluator.baseline=mean or =linear."
        )
    course = play(slots, actor, z)
    mask = course["mask"]
    assert isinstance(mask, torch.Tensor)
    with torch.no_grad():
        episodes = whole_episodes(course, mask, actor).double()
        to_go = episodes.returns_to_go(gamma)
        return PlayedEpisodes(episodes, to_go - baseline(episodes, to_go), to_go[:, 0])


def require_gaussian(policy: Policy, evaluator: str) -> GaussianActor:
    """The policy, where it can say how likely its actions are.

    Raises:
        ConfigError: it cannot.
    """
    if not isinstance(policy, GaussianActor):
        raise ConfigError(
            f"evaluator={evaluator} asks how likely an action is, which {type(policy).__name__} does not know. Give "
            "run=FOLDER of a run with a Gaussian policy: algorithm=reinforce, ppo or epopt."
        )
    return policy


def spread_over(things: Sequence[_Thing], most: int) -> list[_Thing]:
    """At most so many, the last among them, at equal distances: numbers ⌈i·n/m⌉ of n for i = 1 … m."""
    chosen = min(len(things), most)
    return [things[-(-i * len(things) // chosen) - 1] for i in range(1, chosen + 1)]
