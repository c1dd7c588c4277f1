"""Policies that act at once do what each would do alone."""

import pickle
from collections.abc import Callable
from functools import partial
from typing import TypeVar

import numpy as np
import pytest
import torch
from torch import Tensor

from dr_lab.errors import ConfigError
from dr_lab.networks.actor import Actor
from dr_lab.networks.deterministic_actor import DeterministicActor
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import RunningNormaliser
from dr_lab.networks.policy_stack import GaussianPolicyStack, PolicyStack

COUNT, SHARE, WIDTH = 5, 3, 4
LOW, HIGH = np.array([-1.0, 0.0]), np.array([1.0, 6.0])
NORMALISER = partial(RunningNormaliser, clip=10.0)
A = TypeVar("A", bound=Actor)
close = partial(torch.testing.assert_close, rtol=0.0, atol=1e-6)


def gaussian(seed: int, hidden: int = 8) -> GaussianActor:
    return learnt(GaussianActor(WIDTH, LOW, HIGH, seed, NORMALISER, [hidden, hidden], "tanh", log_std=-0.5), seed)


def deterministic(seed: int, noise: float = 0.3) -> DeterministicActor:
    return learnt(DeterministicActor(WIDTH, LOW, HIGH, seed, NORMALISER, [8, 8], "relu", noise), seed)


def learnt(policy: A, seed: int) -> A:
    """With statistics and parameters of its own."""
    draw = torch.Generator().manual_seed(100 + seed)
    policy.normaliser.update(seed + (1.0 + seed) * torch.randn(50, WIDTH, generator=draw))
    with torch.no_grad():
        for parameter in policy.parameters():
            parameter.add_(torch.randn(parameter.shape, generator=draw), alpha=0.3)
    return policy


def observations(*shape: int) -> Tensor:
    return torch.randn(COUNT * SHARE, *shape, WIDTH, generator=torch.Generator().manual_seed(1))


def alone(policies: list[Actor], values: Tensor) -> Tensor:
    return torch.cat([policy(share) for policy, share in zip(policies, values.split(SHARE), strict=True)])


@pytest.mark.parametrize("make", [gaussian, deterministic])
def test_actions_are_those_of_every_policy_alone(make: Callable[[int], Actor]) -> None:
    stack = PolicyStack([make(seed) for seed in range(COUNT)])
    others = [make(seed) for seed in range(COUNT)]
    for _ in range(3):
        close(stack(observations()), alone(others, observations()))
    means = [policy.mean(share) for policy, share in zip(others, observations().split(SHARE), strict=True)]
    close(stack.mean(observations()), torch.cat(means))


def test_log_densities_are_those_of_every_policy_alone() -> None:
    policies = [gaussian(seed) for seed in range(COUNT)]
    seen, action = observations(7), observations(7)[..., :2]
    parts = zip(policies, seen.split(SHARE), action.split(SHARE), strict=True)
    expected = torch.cat([policy.log_prob(share, taken) for policy, share, taken in parts])
    torch.testing.assert_close(GaussianPolicyStack(policies).log_prob(seen, action), expected, rtol=1e-6, atol=1e-5)


def test_what_a_policy_learns_is_taken_over() -> None:
    policies = [gaussian(seed) for seed in range(COUNT)]
    stack = PolicyStack(policies)
    before = stack.mean(observations())
    with torch.no_grad():
        policies[1].body.biases[-1].add_(1.0)
    stack.refresh()
    moved = (stack.mean(observations()) - before).abs().amax(-1) > 1e-3
    assert moved.view(COUNT, SHARE).all(1).tolist() == [False, True, False, False, False]


def test_stacked_parameters_go_through_vmap_and_back() -> None:
    policies = [gaussian(seed) for seed in range(COUNT)]
    stack, seen = PolicyStack(policies), observations().view(COUNT, SHARE, WIDTH)
    stacked = stack.stacked()
    assert stacked["body.weight0"].shape == (COUNT, 8, WIDTH)
    found = torch.vmap(policies[0].distribution)(stacked, seen)
    with torch.no_grad():
        close(found.mean, torch.stack([one.body(part) for one, part in zip(policies, seen, strict=True)]))
        before = stack.mean(observations())
        stack.assign({name: value.flip(0) for name, value in stacked.items()})
        assert (stack.mean(observations()) - before).abs().max() > 1e-2
        stack.assign(stacked)
        assert torch.equal(stack.mean(observations()), before)


def test_slots_are_shared_equally_and_in_order() -> None:
    key = PolicyStack([gaussian(seed) for seed in range(3)]).policy_of_slot(6)
    assert key.dtype == torch.int64
    assert key.tolist() == [0, 0, 1, 1, 2, 2]


def test_unequal_shares_are_refused() -> None:
    stack = PolicyStack([gaussian(seed) for seed in range(COUNT)])
    message = r"5 policies cannot share 12 episodes equally\. Choose a multiple: episodes=5, 10"
    for refused in (lambda: stack(torch.zeros(12, WIDTH)), lambda: stack.policy_of_slot(12)):
        with pytest.raises(ConfigError, match=message):
            refused()


def test_a_worker_gets_the_policies_of_its_slots() -> None:
    policies = [gaussian(seed) for seed in range(4)]
    stack = PolicyStack(policies)
    assert [list(stack.of_worker(k, 2).policies) for k in range(2)] == [policies[:2], policies[2:]]
    assert [list(stack.of_worker(k, 8).policies) for k in range(8)] == [[policies[k // 2]] for k in range(8)]
    with pytest.raises(ConfigError, match="3 workers cannot share 4 policies equally"):
        stack.of_worker(0, 3)


def test_policies_that_differ_in_more_than_their_values_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"Policy 1 has noise = 0\.5, policy 0 0\.3; expected policies that differ"):
        PolicyStack([deterministic(0), deterministic(1, noise=0.5)])
    with pytest.raises(ConfigError, match=r"Policy 1 has the shape of body\.\w+ ="):
        PolicyStack([gaussian(0), gaussian(1, hidden=9)])
    with pytest.raises(ConfigError, match="at least one"):
        PolicyStack([])


def test_a_saved_or_sent_stack_draws_the_same_actions() -> None:
    first, second = (PolicyStack([gaussian(seed + k) for seed in range(COUNT)]) for k in (0, 9))
    first(observations())
    sent = pickle.loads(pickle.dumps(first))
    second.load_state_dict(first.state_dict())
    expected = first(observations())
    assert torch.equal(sent(observations()), expected)
    assert torch.equal(second(observations()), expected)


def test_one_seed_gives_every_policy_random_numbers_of_its_own() -> None:
    stack = PolicyStack([gaussian(0) for _ in range(COUNT)])
    same = torch.zeros(COUNT * SHARE, WIDTH)
    stack.reseed(3)
    first = stack(same)
    assert len(first.view(COUNT, -1).unique(dim=0)) == COUNT
    stack.reseed(3)
    assert torch.equal(stack(same), first)
