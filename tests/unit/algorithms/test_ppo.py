"""PPO finds the optimum of the point mass, continues exactly, and keeps to its limits."""

import itertools
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import pytest
import torch
from point_mass import ASKEW, PointCollector, best, mean_reward, ppo, ppo_arguments
from torch import Tensor

from dr_lab.algorithms.ppo.explicit_surrogate import ExplicitSurrogate
from dr_lab.algorithms.ppo.ppo import PPO
from dr_lab.algorithms.ppo.reward_scale import RawRewards, RunningRewardScale
from dr_lab.algorithms.ppo.surrogate import PolicySamples
from dr_lab.errors import ConfigError
from dr_lab.networks.critic import Critic


def test_reaches_the_optimum() -> None:
    algorithm = ppo()
    collector = PointCollector(algorithm.policies["policy"])
    first = mean_reward(algorithm.deployed)
    figures = [algorithm.update(next(collector)) for _ in range(20)][-1]
    optimum = mean_reward(best)
    assert first < optimum - 0.2
    assert mean_reward(algorithm.deployed) > optimum - 0.02
    assert figures["explained"] > 0.5
    assert 0.0 < figures["kl"] < 0.1


def test_a_batch_is_on_policy_when_its_update_begins() -> None:
    algorithm = ppo()
    collector = PointCollector(algorithm.policies["policy"])
    algorithm.update(next(collector))
    samples = algorithm.samples(next(collector))
    log_prob = algorithm.actor.unit_log_prob(samples.observation, samples.action)
    torch.testing.assert_close(log_prob, samples.log_prob)


def test_continues_exactly() -> None:
    whole, first, second = ppo(), ppo(), ppo(seed=7)
    collectors = [PointCollector(a.policies["policy"]) for a in (whole, first, second)]
    for _ in range(3):
        whole.update(next(collectors[0]))
    first.update(next(collectors[1]))
    second.load_state_dict(first.state_dict())
    collectors[2].load_state_dict(collectors[1].state_dict())
    for _ in range(2):
        second.update(next(collectors[2]))
    for a, b in zip(whole.actor.parameters(), second.actor.parameters(), strict=True):
        assert torch.equal(a, b)


def test_the_actor_rests_beyond_its_divergence_and_the_critic_goes_on() -> None:
    free, held = (PPO(**ppo_arguments(max_kl=limit, actor_rate=0.05)) for limit in (None, 1e-6))
    for algorithm in (free, held):
        algorithm.update(next(PointCollector(algorithm.policies["policy"])))
    assert held.critic_adam.state_dict()["steps"] == free.critic_adam.state_dict()["steps"]
    assert held.actor_adam.state_dict()["steps"] == free.actor_adam.state_dict()["steps"] / 8


class Watched(PPO):
    """Notes what it learns from."""

    def __init__(self, **arguments: Any) -> None:  # noqa: ANN401
        super().__init__(**arguments)
        self.fitted: list[PolicySamples] = []

    def _fit(self, policy: PolicySamples, value: PolicySamples) -> Mapping[str, float]:
        assert policy is value
        self.fitted.append(policy)
        return super()._fit(policy, value)


def test_nothing_is_learnt_at_the_end_in_an_infeasible_context() -> None:
    algorithm = Watched(**ppo_arguments())
    batch = next(PointCollector(algorithm.policies["policy"]))
    infeasible = batch["next", "infeasible"][3] = batch["next", "done"][3]
    rest = ~infeasible.squeeze(-1)
    algorithm.update(batch)
    assert infeasible.any()
    (kept,) = algorithm.fitted
    assert len(kept.target) == batch.numel() - infeasible.sum()
    assert torch.equal(kept.action[90 : 90 + rest.sum()], algorithm.actor.unit(batch["action"][3][rest]))


def test_steps_before_an_infeasible_end_bootstrap_from_its_value_and_do_not_hear_of_its_reward() -> None:
    algorithm = PPO(**ppo_arguments(gamma=0.9, lam=0.5, reward_scale=RawRewards))
    algorithm.critic = Values(1, 0, [4], "tanh")
    batch = next(PointCollector(algorithm.policies["policy"], n=1, steps=4))
    batch["observation"], batch["next", "observation"] = column([5.0, 6.0, 7.0, 8.0]), column([6.0, 7.0, 0.0, 1.0])
    batch["next", "reward"] = column([1.0, 2.0, -5000.0, 3.0])
    end = column([0.0, 0.0, 1.0, 0.0]) > 0
    for flag in ("infeasible", "terminated", "done"):
        batch["next", flag] = end
    samples = algorithm.samples(batch)
    # δ = 1 + 0.9·6 − 5 = 1.4; 2 + 0.9·7 − 6 = 2.3; 0; and in the next episode 3 + 0.9·1 − 8 = −4.1. A = δ + 0.45·A'.
    torch.testing.assert_close(samples.advantage, torch.tensor([[1.4 + 0.45 * 2.3, 2.3, 0.0, -4.1]]))


class Values(Critic):
    """V(o) = o."""

    def forward(self, inputs: Tensor) -> Tensor:
        return inputs[..., 0]


def column(values: list[float]) -> Tensor:
    return torch.tensor(values)[None, :, None]


def test_rates_fall_in_a_line() -> None:
    algorithm = PPO(**ppo_arguments(anneal_frames=960))
    collector = PointCollector(algorithm.policies["policy"])
    rates = [algorithm.update(next(collector))["learning_rate"] for _ in range(3)]
    np.testing.assert_allclose(rates, [3e-3, 1.5e-3, 0.0])


def test_rewards_are_scaled_by_the_spread_of_their_sums() -> None:
    scale = RunningRewardScale(gamma=0.5, clip=10.0)
    reward = torch.tensor([[1.0, 1.0, 4.0]])
    done = torch.tensor([[False, True, False]])
    # Sums 1, 1.5 and, in the next episode, 4: variance (1 + 2.25 + 16)/3 − (6.5/3)².
    std = (19.25 / 3 - (6.5 / 3) ** 2) ** 0.5
    never = torch.zeros_like(done)
    torch.testing.assert_close(scale(reward, done, never), reward / std)
    assert scale.unit == pytest.approx(std)
    # The third goes on: 0.5·4 + 1 = 3.
    scale(reward[:, :1], done[:, :1], never[:, :1])
    torch.testing.assert_close(scale.state_dict()["sum"], torch.tensor([3.0]))
    assert torch.equal(RawRewards(0.5)(reward, done, never), reward)


def test_rewards_of_infeasible_contexts_are_no_part_of_the_scale() -> None:
    with_one, without = (RunningRewardScale(gamma=0.5, clip=10.0) for _ in range(2))
    reward, done = torch.tensor([[1.0, 4.0], [-1e4, 2.0]]), torch.tensor([[False, True], [True, True]])
    with_one(reward, done, torch.tensor([[False, False], [True, False]]))
    without(torch.tensor([[1.0, 4.0, 2.0]]), torch.tensor([[False, True, True]]), torch.zeros(1, 3, dtype=torch.bool))
    assert with_one.unit == pytest.approx(without.unit)
    before = with_one.unit
    with_one(reward[:, :1], torch.ones(2, 1, dtype=torch.bool), torch.ones(2, 1, dtype=torch.bool))
    assert with_one.unit == before


def test_actions_are_in_units_of_their_bounds_for_the_surrogate() -> None:
    algorithm = PPO(**ppo_arguments(interface=ASKEW))
    batch = next(PointCollector(algorithm.policies["policy"]))
    samples = algorithm.samples(batch)
    torch.testing.assert_close(samples.action, (batch["action"] + 1.0) / 2.0)
    log_prob = algorithm.actor.unit_log_prob(samples.observation, samples.action)
    torch.testing.assert_close(log_prob, samples.log_prob)


def test_training_on_keeps_a_share_of_the_rates_and_draws_otherwise() -> None:
    algorithm = PPO(**ppo_arguments(anneal_frames=960, further_share=0.3))
    collector = PointCollector(algorithm.policies["policy"])
    rates = [algorithm.update(next(collector))["learning_rate"] for _ in range(2)]
    assert rates == pytest.approx([3e-3, 1.5e-3])
    algorithm.begin_schedules()
    again = PPO(**ppo_arguments(anneal_frames=960, further_share=0.3))
    again.load_state_dict(algorithm.state_dict())
    for one in (algorithm, again):
        rates = [one.update(next(collector))["learning_rate"] for _ in range(3)]
        assert rates == pytest.approx([0.9e-3] * 3)
    drawn = []
    for seed in (0, 1):
        algorithm.explore_anew(seed)
        drawn.append({algorithm.generator.initial_seed(), algorithm.actor.generator.initial_seed()})
    assert len(drawn[0] | drawn[1]) == 4


def test_neighbouring_seeds_share_no_numbers() -> None:
    algorithms = [ppo(seed) for seed in range(3)]
    weights = [network.body.weights[0] for a in algorithms for network in (a.actor, a.critic)]
    for first, second in itertools.combinations(weights, 2):
        assert first.shape == second.shape
        assert not torch.equal(first, second)
    generators = [generator for a in algorithms for generator in (a.actor.generator, a.generator)]
    assert len({generator.initial_seed() for generator in generators}) == 6


def test_new_episodes_begin_with_nothing_earned() -> None:
    algorithm = ppo()
    algorithm.update(next(PointCollector(algorithm.policies["policy"], steps=7)))  # no episode ends at its last step
    before = algorithm.reward_scale.state_dict()
    algorithm.forget_episodes()
    after = algorithm.reward_scale.state_dict()
    assert before["sum"].abs().min() > 0.0
    assert after["sum"].abs().max() == 0.0
    assert {k: v for k, v in after.items() if k != "sum"} == {k: v for k, v in before.items() if k != "sum"}


def test_a_bad_number_is_told() -> None:
    with pytest.raises(ConfigError, match=r"algorithm\.epochs is 0"):
        PPO(**ppo_arguments(epochs=0))
    with pytest.raises(ConfigError, match=r"algorithm\.gamma is 1\.1; expected at most 1\."):
        PPO(**ppo_arguments(gamma=1.1))
    with pytest.raises(ConfigError, match=r"algorithm\.lam is -0\.5; expected at least 0\."):
        PPO(**ppo_arguments(lam=-0.5))
    with pytest.raises(ConfigError, match=r"algorithm\.anneal_frames is 0; expected a number above 0"):
        PPO(**ppo_arguments(anneal_frames=0))
    with pytest.raises(ConfigError, match=r"algorithm\.max_kl is -1; expected a number above 0"):
        PPO(**ppo_arguments(max_kl=-1.0))
    with pytest.raises(ConfigError, match=r"algorithm\.adam_epsilon is -1; expected at least 0"):
        PPO(**ppo_arguments(adam_epsilon=-1.0))
    with pytest.raises(ConfigError, match=r"algorithm\.surrogate\.clip is 0; expected a number above 0"):
        PPO(**ppo_arguments(surrogate=partial(ExplicitSurrogate, clip=0.0, entropy_weight=0.0, critic_weight=0.5)))
    with pytest.raises(ConfigError, match=r"algorithm\.reward_scale\.clip is -1"):
        PPO(**ppo_arguments(reward_scale=partial(RunningRewardScale, clip=-1.0)))
