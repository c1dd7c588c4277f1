"""Advantages by hand: truncation bootstraps, termination does not."""

import torch
from torch import Tensor
from torchrl.objectives.value.functional import generalized_advantage_estimate

from dr_lab.algorithms.ppo.gae import advantages

GAMMA, LAM = 0.5, 0.5


def row(*values: float) -> Tensor:
    return torch.tensor([values])


def estimate(terminated: Tensor, done: Tensor) -> Tensor:
    # V(s) = 2, V(s') = 4 throughout: δ = r + 2 − 2 = r, or r − 2 where terminated.
    reward, value = row(1.0, 2.0, 3.0), torch.full((1, 3), 2.0)
    return advantages(reward, value, 2 * value, terminated > 0, done > 0, GAMMA, LAM)


def test_an_unbroken_episode_sums_its_errors() -> None:
    # 3; 2 + 3/4 = 2.75; 1 + 2.75/4 = 1.6875
    torch.testing.assert_close(estimate(row(0, 0, 0), row(0, 0, 0)), row(1.6875, 2.75, 3.0))


def test_truncation_bootstraps_and_termination_does_not() -> None:
    # Cut after the second step: its error keeps γV(s'), and nothing of the third comes before it.
    torch.testing.assert_close(estimate(row(0, 0, 0), row(0, 1, 0)), row(1.5, 2.0, 3.0))
    # Ended there: δ = 2 − 2 = 0.
    torch.testing.assert_close(estimate(row(0, 1, 0), row(0, 1, 0)), row(1.0, 0.0, 3.0))


def test_equals_torchrl() -> None:
    generator = torch.Generator().manual_seed(0)
    reward, value, next_value = torch.randn(3, 5, 40, generator=generator)
    done = torch.rand(5, 40, generator=generator) < 0.2
    terminated = done & (torch.rand(5, 40, generator=generator) < 0.5)
    fields = (value, next_value, reward, done, terminated)
    expected, _ = generalized_advantage_estimate(0.99, 0.95, *(field.unsqueeze(-1) for field in fields))
    ours = advantages(reward, value, next_value, terminated, done, 0.99, 0.95)
    torch.testing.assert_close(ours, expected.squeeze(-1))
