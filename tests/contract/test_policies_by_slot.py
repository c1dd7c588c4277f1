"""Collectors carry several policies that share the slots: each plays what it would play alone."""

from functools import partial

import pytest
import torch
from settings import setting
from test_collectors import KINDS, LAYOUT, Kind
from torch import Tensor

from dr_lab.collectors.collector import Collector, Policy
from dr_lab.collectors.lean import LeanCollector
from dr_lab.collectors.shares import shares
from dr_lab.envs.mujoco_env import MujocoEnv
from dr_lab.errors import ConfigError
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import RunningNormaliser
from dr_lab.networks.policy_stack import GaussianPolicyStack

COUNT, SLOTS, STEPS = 16, 32, 25


def env(slots: int) -> MujocoEnv:
    return setting("cartpole").make(None, slots, 0, threads=1)


def actor(seed: int) -> GaussianActor:
    episodes = env(1).episodes
    normaliser = partial(RunningNormaliser, clip=10.0)
    policy = GaussianActor(
        episodes.observation.shape[1], episodes.low, episodes.high, seed, normaliser, [64, 64], "tanh", log_std=-0.5
    )
    policy.normaliser.update((1.0 + 0.1 * seed) * torch.eye(episodes.observation.shape[1]))
    return policy


def collected(collector: Collector, policies: dict[int, GaussianActor]) -> list[dict[object, Tensor]]:
    with collector as one:
        for seed, policy in policies.items():
            policy.reseed(seed)  # TorchRL's collector tries the policy out
        return [{key: batch[key] for key in batch.keys(True, True)} for batch in (next(one), next(one))]


@pytest.mark.parametrize("kind", KINDS)
def test_a_batch_of_many_policies_is_the_batches_of_each_alone(kind: Kind) -> None:
    together = env(SLOTS)
    beginnings = shares(together.state_dict(), SLOTS, COUNT)
    policies = {seed: actor(seed) for seed in range(COUNT)}
    found = collected(kind(together, GaussianPolicyStack(list(policies.values())), STEPS), policies)
    separate = []
    for seed, beginning in enumerate(beginnings):
        alone = env(SLOTS // COUNT)
        alone.load_state_dict(beginning)
        policy = actor(seed)
        separate.append(collected(LeanCollector(alone, policy, STEPS), {seed: policy}))
    for k, batch in enumerate(found):
        assert set(batch) == LAYOUT | {"policy"}
        for key in LAYOUT:
            expected = torch.cat([each[k][key] for each in separate])
            torch.testing.assert_close(batch[key], expected, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_the_key_names_the_policy_of_every_row(kind: Kind) -> None:
    with kind(env(6), GaussianPolicyStack([actor(seed) for seed in range(3)]), 4) as one:
        key = next(one)["policy"]
    assert key.dtype == torch.int64
    assert key.tolist() == [[k] * 4 for k in (0, 0, 1, 1, 2, 2)]


@pytest.mark.parametrize("kind", KINDS)
def test_what_policies_learn_between_batches_acts_in_the_next(kind: Kind) -> None:
    policies = [actor(seed) for seed in range(2)]
    with kind(env(4), GaussianPolicyStack(policies), 4) as one:
        next(one)
        with torch.no_grad():
            policies[1].body.biases[-1].add_(100.0)
        large = next(one)["action"].abs().amax((1, 2)) > 10.0
    assert large.tolist() == [False, False, True, True]


@pytest.mark.parametrize("kind", KINDS)
def test_unequal_shares_are_refused(kind: Kind) -> None:
    policy: Policy = GaussianPolicyStack([actor(seed) for seed in range(3)])
    with pytest.raises(ConfigError, match="3 policies cannot share 4 episodes equally"):
        next(kind(env(4), policy, 4))
