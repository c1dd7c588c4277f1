"""Many PPOs that find their gradients together learn what each would learn alone."""

from collections.abc import Mapping
from typing import Any, cast

import numpy as np
import pytest
import torch
from point_mass import PointCollector, ppo_arguments
from tensordict import TensorDict

from dr_lab.algorithms.ppo.ppo import PPO
from dr_lab.algorithms.ppo.ppo_stack import PPOStack
from dr_lab.algorithms.ppo.surrogate_stack import SurrogateStack
from dr_lab.networks.flat import FlatParameters

N, SHARE = 3, 8


def members(**changes: Any) -> list[PPO]:  # noqa: ANN401
    return [PPO(**ppo_arguments(seed=seed, **changes)) for seed in range(N)]


def batches(stack: PPOStack, count: int) -> list[TensorDict]:
    """Of the policies as they are, which learn nothing meanwhile."""
    collector = PointCollector(stack.acting, n=N * SHARE)
    return [next(collector) for _ in range(count)]


def part(batch: TensorDict, k: int) -> TensorDict:
    return cast(TensorDict, batch[k * SHARE : (k + 1) * SHARE])


@pytest.mark.parametrize("max_kl", [None, 0.01], ids=["all epochs", "some rest"])
def test_each_learns_as_it_would_alone(max_kl: float | None) -> None:
    alone, stack = members(max_kl=max_kl), PPOStack(members(max_kl=max_kl))
    for batch in batches(stack, 3):
        together = stack.update(batch)
        figures = [one.update(part(batch, k)) for k, one in enumerate(alone)]
        for key in ("kl", "objective", "critic_loss", "explained", "std"):
            if max_kl is None or key not in ("objective",):  # a mean over the steps of those that learn
                expected = np.mean([each[key] for each in figures])
                assert together[key] == pytest.approx(expected, rel=1e-3, abs=1e-5)
    steps = [one.actor_adam.state_dict()["steps"] for one in alone]
    assert steps == [one.actor_adam.state_dict()["steps"] for one in stack.members]
    assert (len(set(steps)) > 1) is (max_kl is not None)  # the policies rest at different times
    for one, other in zip(alone, stack.members, strict=True):
        for name in ("actor", "critic"):
            _same(getattr(one, name).state_dict(), getattr(other, name).state_dict(), atol=1e-5)


def test_the_gradient_of_each_is_the_same_as_by_its_own_loss() -> None:
    every = members()
    stack = PPOStack(every)
    batch = batches(stack, 1)[0]
    samples = [one.samples(part(batch, k)) for k, one in enumerate(every)]
    rows = [each.at(torch.ones_like(each.target, dtype=torch.bool)) for each in samples]
    terms = SurrogateStack([one.surrogate for one in every]).differentiate(rows)
    for k, one in enumerate(every):
        found = [p.gradient.clone() for p in (one.surrogate.actor_parameters, one.surrogate.critic_parameters)]
        expected = one.surrogate.differentiate(rows[k])
        torch.testing.assert_close(terms.critic[k], expected.critic)
        torch.testing.assert_close(terms.objective[k], expected.objective)
        torch.testing.assert_close(found[0], one.surrogate.actor_parameters.gradient, rtol=1e-4, atol=1e-6)
        torch.testing.assert_close(found[1], one.surrogate.critic_parameters.gradient, rtol=1e-4, atol=1e-6)


def test_an_infeasible_end_of_one_leaves_the_others_as_many_samples() -> None:
    stack = PPOStack(members())
    batch = batches(stack, 1)[0]
    ends = batch["next", "done"][:2]
    batch["next", "infeasible"][:2] = ends
    least = SHARE * 30 - int(ends.sum())
    parts = [one.samples(part(batch, k)) for k, one in enumerate(stack.members)]
    assert least < parts[0].target.numel()
    before = [one.actor_adam.state_dict()["steps"] for one in stack.members]
    stack.update(batch)
    steps = [one.actor_adam.state_dict()["steps"] for one in stack.members]
    minibatches = -(-least // 60) - (least % 60 == 1)
    assert steps == [first + 8 * minibatches for first in before]


def test_flat_parameters_of_a_stack_are_rows() -> None:
    weight, bias = torch.nn.Parameter(torch.randn(2, 3, 4)), torch.nn.Parameter(torch.randn(2, 1, 3))
    expected = torch.cat([weight.detach().reshape(2, 12), bias.detach().reshape(2, 3)], 1)
    flat = FlatParameters([weight, bias], stack=(2,))
    torch.testing.assert_close(flat.vector, expected)
    flat.vector[1, 12:] = 7.0
    assert bias[1].eq(7.0).all()
    assert not bias[0].eq(7.0).any()
    flat.differentiate((weight * 2.0).sum() + (bias[0] * 3.0).sum())
    assert flat.gradient.tolist() == [[2.0] * 12 + [3.0] * 3, [2.0] * 12 + [0.0] * 3]


def _same(one: Mapping[str, Any], other: Mapping[str, Any], atol: float) -> None:
    for name, value in one.items():
        if value.is_floating_point():  # the state of the random numbers is another matter
            torch.testing.assert_close(value, other[name], rtol=1e-3, atol=atol)
