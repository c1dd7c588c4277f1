"""PPO's loss under parameters that are given: its own values, and derivatives of first and second order."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
import torch
from torch import Tensor
from torch.func import grad

from dr_lab.algorithms.ppo.explicit_surrogate import ExplicitSurrogate
from dr_lab.algorithms.ppo.surrogate import PolicySamples
from dr_lab.networks.critic import Critic
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import NoNormaliser

Parameters = dict[str, Tensor]
Loss = Callable[[Parameters], Tensor]
WIDTH, ACTIONS, ROWS = 5, 2, 40
STEP = 1e-5  # of finite differences, in float64


def draw(seed: int) -> Callable[..., Tensor]:
    return partial(torch.randn, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


def networks() -> tuple[GaussianActor, Critic]:
    bound = np.ones(ACTIONS)
    actor = GaussianActor(WIDTH, -bound, bound, 0, NoNormaliser, [7, 6], "tanh", log_std=-0.3)
    return actor, Critic(WIDTH, 1, [7, 6], "tanh")


def samples(actor: GaussianActor) -> PolicySamples:
    """Some ratios are clipped above, some below and some not."""
    normal = draw(2)
    observation, action = normal(ROWS, WIDTH), normal(ROWS, ACTIONS)
    with torch.no_grad():
        log_prob = actor.unit_log_prob(observation.float(), action.float()).double() + 0.3 * normal(ROWS)
    return PolicySamples(observation, action, log_prob, 2.0 + 3.0 * normal(ROWS), normal(ROWS))


def losses() -> dict[str, tuple[Loss, Parameters]]:
    actor, critic = networks()
    surrogate = ExplicitSurrogate(actor, critic, clip=0.2, entropy_weight=0.01, critic_weight=0.5)
    batch = samples(actor)
    return {
        "actor": (partial(surrogate.actor_loss, samples=batch), doubled(actor)),
        "critic": (partial(surrogate.critic_loss, samples=batch), doubled(critic)),
    }


def doubled(network: torch.nn.Module) -> Parameters:
    return {name: value.detach().double() for name, value in network.named_parameters()}


def moved(parameters: Parameters, direction: Parameters, size: float) -> Parameters:
    return {name: value + size * direction[name] for name, value in parameters.items()}


def direction(parameters: Parameters, seed: int = 3) -> Parameters:
    normal = draw(seed)
    return {name: normal(value.shape) for name, value in parameters.items()}


def inner(one: Parameters, other: Parameters) -> Tensor:
    return torch.stack([(one[name] * other[name]).sum() for name in one]).sum()


def test_value_and_gradient_equal_the_written_out_ones() -> None:
    actor, critic = networks()
    surrogate = ExplicitSurrogate(actor, critic, clip=0.2, entropy_weight=0.01, critic_weight=0.5)
    batch = PolicySamples(*(field.float() for field in samples(actor)))
    terms = surrogate.differentiate(batch)
    own = (
        (surrogate.actor_loss, actor, surrogate.actor_parameters, terms.objective + terms.entropy),
        (surrogate.critic_loss, critic, surrogate.critic_parameters, terms.critic),
    )
    for loss, network, flat, value in own:
        parameters = {name: parameter.detach() for name, parameter in network.named_parameters()}
        torch.testing.assert_close(loss(parameters, batch), value, rtol=0.0, atol=1e-6)
        slopes = grad(loss)(parameters, batch)
        for name, parameter in network.named_parameters():
            torch.testing.assert_close(slopes[name], flat.gradient_of(parameter), rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("name", ["actor", "critic"])
def test_the_gradient_is_that_of_finite_differences(name: str) -> None:
    loss, parameters = losses()[name]
    along = direction(parameters)
    expected = (loss(moved(parameters, along, STEP)) - loss(moved(parameters, along, -STEP))) / (2 * STEP)
    found = inner(grad(loss)(parameters), along)
    assert abs(found) > 1e-2
    torch.testing.assert_close(found, expected, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("name", ["actor", "critic"])
def test_the_hessian_times_a_vector_is_that_of_finite_differences(name: str) -> None:
    loss, parameters = losses()[name]
    along, slope = direction(parameters), grad(loss)
    found = grad(lambda at: inner(slope(at), along))(parameters)
    above, below = slope(moved(parameters, along, STEP)), slope(moved(parameters, along, -STEP))
    assert inner(found, found) > 1e-2
    for key in parameters:
        torch.testing.assert_close(found[key], (above[key] - below[key]) / (2 * STEP), rtol=1e-5, atol=1e-5)


def test_a_loss_after_a_step_is_differentiated_through_the_step() -> None:
    loss, parameters = losses()["actor"]

    def adapted(before: Parameters) -> Tensor:
        return loss(moved(before, grad(loss)(before), -0.1))

    along = direction(parameters)
    expected = (adapted(moved(parameters, along, STEP)) - adapted(moved(parameters, along, -STEP))) / (2 * STEP)
    torch.testing.assert_close(inner(grad(adapted)(parameters), along), expected, rtol=1e-5, atol=1e-5)
    # The first-order approximation is something else.
    after = grad(loss)(moved(parameters, grad(loss)(parameters), -0.1))
    assert abs(inner(after, along) - expected) > 1e-3
