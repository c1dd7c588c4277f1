"""The Gaussian policy and its normaliser."""

import pickle
from functools import partial

import numpy as np
import pytest
import torch
from torch.distributions import Independent, Normal

from dr_lab.errors import ConfigError
from dr_lab.networks.deterministic_actor import DeterministicActor
from dr_lab.networks.gaussian import Gaussian
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.mlp import Activation
from dr_lab.networks.normaliser import NoNormaliser, RunningNormaliser


def actor(seed: int = 0) -> GaussianActor:
    low, high = np.array([-1.0, 0.0]), np.array([1.0, 6.0])
    return GaussianActor(4, low, high, seed, partial(RunningNormaliser, clip=10.0), [8], "tanh", log_std=-0.5)


def test_log_density_is_that_of_the_scaled_gaussian() -> None:
    policy = actor()
    observation = torch.randn(3, 5, 4, generator=torch.Generator().manual_seed(1))
    action = torch.randn(3, 5, 2, generator=torch.Generator().manual_seed(2))
    std = torch.tensor([1.0, 3.0]) * torch.exp(torch.tensor(-0.5))
    expected = Independent(Normal(policy.mean(observation), std), 1)
    torch.testing.assert_close(policy.log_prob(observation, action), expected.log_prob(action))
    entropy = Gaussian(torch.zeros(2), policy.log_std).entropy()
    torch.testing.assert_close(entropy + np.log(3.0), expected.entropy()[0, 0])


def test_the_distribution_under_the_actors_own_parameters_is_its_own() -> None:
    policy, parameters = actor(0), dict(actor(1).named_parameters())
    observation, unit = torch.ones(5, 4), torch.full((5, 2), 0.1)
    own = policy.distribution(dict(policy.named_parameters()), observation)
    torch.testing.assert_close(own.log_prob(unit), policy.unit_log_prob(observation, unit))
    other = policy.distribution(parameters, observation)
    torch.testing.assert_close(other.log_prob(unit), actor(1).unit_log_prob(observation, unit))
    # The actor has kept what it had.
    torch.testing.assert_close(own.log_prob(unit), policy.unit_log_prob(observation, unit))


def test_the_deterministic_action_under_its_own_parameters_is_its_own() -> None:
    low, high = np.array([-1.0, 0.0]), np.array([1.0, 6.0])
    policy = DeterministicActor(4, low, high, 0, NoNormaliser, [8], "relu", noise=0.1)
    observation = torch.ones(5, 4)
    unit = policy.unit_action(dict(policy.named_parameters()), observation)
    torch.testing.assert_close(unit, policy.unit(policy.mean(observation)))


def test_actions_follow_the_gaussian_and_touch_no_global_random_numbers() -> None:
    before = torch.random.get_rng_state()
    policy = actor()
    action = policy(torch.zeros(20_000, 4))
    torch.testing.assert_close(action.mean(0), torch.tensor([0.0, 3.0]), atol=0.05, rtol=0.0)
    torch.testing.assert_close(action.std(0), torch.tensor([1.0, 3.0]) * np.exp(-0.5), atol=0.03, rtol=0.0)
    assert torch.equal(torch.random.get_rng_state(), before)


def test_a_saved_policy_draws_the_same_actions() -> None:
    first, second = actor(0), actor(1)
    observation = torch.ones(6, 4)
    first(observation)
    first.normaliser.update(torch.randn(50, 4, generator=torch.Generator().manual_seed(3)))
    second.load_state_dict(first.state_dict())
    assert torch.equal(first(observation), second(observation))


@pytest.mark.parametrize("activation", ["tanh", "relu"])
def test_a_policy_can_be_sent_to_another_process(activation: Activation) -> None:
    policy = GaussianActor(4, np.array([-1.0]), np.array([1.0]), 0, NoNormaliser, [8], activation, log_std=-0.5)
    sent = pickle.loads(pickle.dumps(policy))
    observation = torch.ones(6, 4)
    assert torch.equal(sent(observation), policy(observation))


def test_statistics_of_batches_are_those_of_all_rows() -> None:
    rows = 3.0 + 2.0 * torch.randn(90, 4, generator=torch.Generator().manual_seed(4))
    normaliser = RunningNormaliser(4, clip=10.0)
    for batch in rows.split([20, 30, 40]):
        normaliser.update(batch.reshape(2, -1, 4))
    torch.testing.assert_close(normaliser.mean.float(), rows.mean(0))
    torch.testing.assert_close(normaliser.variance.float(), rows.var(0, correction=0))
    seen = normaliser(rows)
    torch.testing.assert_close(seen.mean(0), torch.zeros(4), atol=1e-5, rtol=0.0)
    torch.testing.assert_close(seen.std(0, correction=0), torch.ones(4))
    assert normaliser(torch.full((4,), 1e6)).max() == 10.0


def test_without_normaliser_observations_stay() -> None:
    normaliser = NoNormaliser(4)
    normaliser.update(torch.ones(3, 4))
    assert torch.equal(normaliser(torch.full((2, 4), 5.0)), torch.full((2, 4), 5.0))


def test_a_whole_number_is_a_logarithm_too() -> None:
    bounds = np.array([-1.0]), np.array([1.0])
    policy = GaussianActor(2, *bounds, 0, NoNormaliser, [4], "tanh", log_std=0)
    assert policy.log_std.dtype == torch.float32


def test_a_normaliser_that_cuts_everything_off_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"normaliser\.clip is 0; expected a number above 0"):
        RunningNormaliser(1, clip=0.0)
