"""Both collectors gather the same, in the same layout, and go on where they stopped."""

from collections.abc import Callable

import numpy as np
import pytest
import torch
from settings import setting
from torch import Tensor, nn

from dr_lab.collectors.collector import Collector
from dr_lab.collectors.lean import LeanCollector
from dr_lab.collectors.torchrl import TorchRLCollector

NENV, STEPS = 3, 40
Kind = Callable[..., Collector]
KINDS: list[Kind] = [LeanCollector, TorchRLCollector]
LAYOUT = {"observation", "context", "proposal", "action", "action_log_prob"} | {
    ("next", key)
    for key in ("observation", "context", "proposal", "reward", "done", "terminated", "truncated", "infeasible")
}


class Gaussian(nn.Module):
    def __init__(self, observation: int, action: int) -> None:
        super().__init__()
        torch.manual_seed(0)
        self.mean = nn.Linear(observation, action)

    def forward(self, observation: Tensor) -> Tensor:
        mean = self.mean(observation)
        return mean + torch.randn_like(mean)

    def log_prob(self, observation: Tensor, action: Tensor) -> Tensor:
        return torch.distributions.Normal(self.mean(observation), 1.0).log_prob(action).sum(-1)


class Deterministic(nn.Module):
    def forward(self, observation: Tensor) -> Tensor:
        return 0.1 * observation[:, :3]


def collector(kind: Kind, policy: nn.Module | None = None, slots: int = NENV, steps: int = STEPS) -> Collector:
    env = setting("hopper", "env/context=hopper/friction", "env.task.time_limit=8").make(None, slots, 0, threads=1)
    return kind(env, policy or Gaussian(11, 3), steps)


def test_lean_and_torchrl_gather_the_same() -> None:
    batches = []
    for kind in KINDS:
        with collector(kind) as one:
            torch.manual_seed(1)
            batches.append([next(one) for _ in range(2)])
    for lean, torchrl in zip(*batches, strict=True):
        assert set(lean.keys(True, True)) == set(torchrl.keys(True, True)) == LAYOUT
        for key in LAYOUT:
            assert lean[key].dtype == torchrl[key].dtype
            torch.testing.assert_close(lean[key], torchrl[key], rtol=0, atol=0)
        assert lean.batch_size == torchrl.batch_size == (NENV, STEPS)


@pytest.mark.parametrize("kind", KINDS)
def test_the_row_after_an_end_begins_anew_and_others_go_on(kind: Kind) -> None:
    with collector(kind) as one:
        batch = next(one)
    now, then = batch["observation"][:, 1:], batch["next", "observation"][:, :-1]
    done = batch["next", "done"][:, :-1, 0]
    assert done.any()
    assert batch["next", "truncated"].any()
    assert torch.equal(now[~done], then[~done])
    assert (now[done] != then[done]).any(-1).all()


@pytest.mark.parametrize(("slots", "steps"), [(NENV, 1), (1, 5), (1, 1)])
@pytest.mark.parametrize("kind", KINDS)
def test_a_batch_stays_as_it_is_while_more_is_collected(kind: Kind, slots: int, steps: int) -> None:
    with collector(kind, slots=slots, steps=steps) as one:
        kept = next(one)
        before = kept.clone()
        next(one)
    for key in LAYOUT:
        assert torch.equal(kept[key], before[key]), key


@pytest.mark.parametrize("kind", KINDS)
def test_what_ended_because_its_context_is_infeasible_is_told(kind: Kind) -> None:
    env = setting("hopper", "env/context=hopper/torso_size").make(None, NENV, 0, threads=1)
    env.set_contexts(np.array([[0.05], [-0.02], [0.05]]))  # the second does not compile
    env.reset()
    with kind(env, Gaussian(11, 3), 4) as one:
        batch = next(one)
    assert batch["next", "infeasible"][..., 0].tolist() == [[False] * 4, [True] * 4, [False] * 4]
    for key in ("terminated", "done"):
        assert batch["next", key][1].all()


@pytest.mark.parametrize("kind", KINDS)
def test_log_probabilities_are_those_of_the_policy(kind: Kind) -> None:
    policy = Gaussian(11, 3)
    with collector(kind, policy) as one:
        batch = next(one)
    expected = policy.log_prob(batch["observation"], batch["action"])
    torch.testing.assert_close(batch["action_log_prob"], expected)
    assert not batch["action_log_prob"].requires_grad


@pytest.mark.parametrize("kind", KINDS)
def test_a_policy_without_likelihoods_gets_none(kind: Kind) -> None:
    with collector(kind, Deterministic()) as one:
        assert "action_log_prob" not in next(one).keys()  # noqa: SIM118 (a tensordict iterates over its rows)


@pytest.mark.parametrize("kind", KINDS)
def test_resumed_equals_uninterrupted(kind: Kind) -> None:
    with collector(kind) as one, collector(kind) as other:
        next(one)
        state, rng = one.state_dict(), torch.get_rng_state()
        expected = next(one)
        next(other)
        other.load_state_dict(state)
        torch.set_rng_state(rng)
        found = next(other)
    for key in LAYOUT:
        assert torch.equal(found[key], expected[key])
