"""PPO's written-out loss equals TorchRL's `ClipPPOLoss` in value and gradient."""

from functools import partial

import numpy as np
import torch

from dr_lab.algorithms.ppo.explicit_surrogate import ExplicitSurrogate
from dr_lab.algorithms.ppo.surrogate import PolicySamples, Surrogate
from dr_lab.algorithms.ppo.torchrl_surrogate import TorchRLSurrogate
from dr_lab.networks.critic import Critic
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import NoNormaliser

WIDTH, ACTIONS, ROWS = 11, 3, 64


def old_actor() -> GaussianActor:
    bound = np.ones(ACTIONS)
    return GaussianActor(WIDTH, -bound, bound, 0, NoNormaliser, [64, 64], "tanh", log_std=-0.3)


def surrogate(kind: type[Surrogate]) -> Surrogate:
    return kind(old_actor(), Critic(WIDTH, 1, [64, 64], "tanh"), clip=0.2, entropy_weight=0.01, critic_weight=0.5)


def samples() -> PolicySamples:
    draw = partial(torch.randn, generator=torch.Generator().manual_seed(2))
    observation, action = draw(ROWS, WIDTH), draw(ROWS, ACTIONS)
    log_prob = old_actor().unit_log_prob(observation, action).detach() + 0.3 * draw(ROWS)
    return PolicySamples(observation, action, log_prob, 2.0 + 3.0 * draw(ROWS), draw(ROWS))


def test_values_and_gradients_equal_torchrl() -> None:
    ours, theirs = surrogate(ExplicitSurrogate), surrogate(TorchRLSurrogate)
    batch = samples()
    for mine, expected in zip(ours.differentiate(batch), theirs.differentiate(batch), strict=True):
        torch.testing.assert_close(mine, expected, rtol=1e-6, atol=1e-6)
    # Some ratios are clipped above, some below and some not.
    ratio = (old_actor().unit_log_prob(batch.observation, batch.action).detach() - batch.log_prob).exp()
    assert (ratio > 1.2).any()
    assert (ratio < 0.8).any()
    for name in ("actor_parameters", "critic_parameters"):
        mine, expected = getattr(ours, name).gradient, getattr(theirs, name).gradient
        assert expected.abs().max() > 1e-2
        torch.testing.assert_close(mine, expected, rtol=0.0, atol=1e-6)


def test_minibatches_hold_every_sample_once() -> None:
    batch = samples()
    parts = list(batch.minibatches(10, torch.Generator().manual_seed(0)))
    assert [len(part.target) for part in parts] == [10] * 6 + [4]
    together = torch.cat([part.target for part in parts])
    assert torch.equal(together.sort().values, batch.target.sort().values)
    assert not torch.equal(together, batch.target)
    # A remainder of one has no spread to be standardised by.
    assert [len(part.target) for part in batch.minibatches(9, torch.Generator().manual_seed(0))] == [9] * 7
