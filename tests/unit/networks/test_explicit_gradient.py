"""Networks' written-out gradients, optimiser and clipping equal torch's."""

from typing import get_args

import pytest
import torch
from torch import nn

from dr_lab.networks.adam import Adam, clip_norm
from dr_lab.networks.flat import FlatParameters
from dr_lab.networks.mlp import MLP, Activation


def network(activation: Activation = "tanh") -> MLP:
    return MLP(5, [7, 6], 3, activation, last_gain=1.0, generator=torch.Generator().manual_seed(0))


@pytest.mark.parametrize("activation", get_args(Activation))
def test_backward_equals_autograd(activation: Activation) -> None:
    mlp = network(activation)
    x, slope = torch.randn(2, 40, 5, generator=torch.Generator().manual_seed(1)).unbind(0)
    slope = slope[:, :3]
    flat = FlatParameters(mlp.parameters())
    flat.differentiate((mlp(x) * slope).sum())
    expected = flat.gradient.clone()
    flat.gradient.zero_()
    with torch.no_grad():
        mlp.backward(mlp.layers(x), slope, *flat.gradients_of(mlp))
    torch.testing.assert_close(flat.gradient, expected)


def test_a_flat_network_is_the_same_network() -> None:
    mlp = network()
    x = torch.ones(2, 5)
    before = mlp(x)
    flat = FlatParameters(mlp.parameters())
    torch.testing.assert_close(mlp(x), before)
    flat.vector.mul_(0.0)
    assert (mlp(x) == 0.0).all()
    mlp.load_state_dict(network().state_dict())
    torch.testing.assert_close(mlp(x), before)
    assert flat.vector.abs().sum() > 0


def test_adam_and_clipping_equal_torch() -> None:
    ours, theirs = network(), network()
    flat = FlatParameters(ours.parameters())
    adam, expected = Adam(flat, epsilon=1e-8), torch.optim.Adam(theirs.parameters(), lr=1e-2)
    x = torch.randn(20, 5, generator=torch.Generator().manual_seed(2))
    for _ in range(5):
        flat.differentiate(ours(x).square().sum())
        clip_norm([flat.gradient], 0.5)
        adam.step(1e-2)
        expected.zero_grad()
        theirs(x).square().sum().backward()
        nn.utils.clip_grad_norm_(theirs.parameters(), 0.5)
        expected.step()
    for a, b in zip(ours.parameters(), theirs.parameters(), strict=True):
        torch.testing.assert_close(a, b)


def test_clipping_is_by_the_common_norm() -> None:
    gradients = [torch.tensor([3.0]), torch.tensor([4.0])]
    clip_norm(gradients, 1.0)
    torch.testing.assert_close(torch.cat(gradients), torch.tensor([0.6, 0.8]))
    clip_norm(gradients, 2.0)
    torch.testing.assert_close(torch.cat(gradients), torch.tensor([0.6, 0.8]))


def test_adam_continues_exactly() -> None:
    one, two = (FlatParameters(network().parameters()) for _ in range(2))
    whole, first = Adam(one, epsilon=1e-8), Adam(two, epsilon=1e-8)
    for flat in (one, two):
        flat.gradient.fill_(0.3)
    whole.step(0.1)
    first.step(0.1)
    second = Adam(two, epsilon=1e-8)
    second.load_state_dict(first.state_dict())
    whole.step(0.1)
    second.step(0.1)
    assert torch.equal(one.vector, two.vector)
