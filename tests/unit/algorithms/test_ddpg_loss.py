"""DDPG's written-out losses equal TorchRL's `DDPGLoss`, and its targets `SoftUpdate`, in value and gradient."""

from functools import partial

import numpy as np
import pytest
import torch
from tensordict import TensorDict
from tensordict.nn import TensorDictModule
from torch import Tensor, nn
from torchrl.modules import ValueOperator
from torchrl.objectives import DDPGLoss as TorchRLLoss
from torchrl.objectives import SoftUpdate

from dr_lab.algorithms.ddpg.loss import DDPGLoss, Transitions
from dr_lab.networks.critic import Critic
from dr_lab.networks.deterministic_actor import DeterministicActor
from dr_lab.networks.normaliser import NoNormaliser

WIDTH, ACTIONS, ROWS, GAMMA, TAU = 8, 2, 64, 0.97, 0.1


class Joined(nn.Module):
    def __init__(self, body: nn.Module) -> None:
        super().__init__()
        self.body = body

    def forward(self, observation: Tensor, action: Tensor) -> Tensor:
        return self.body(torch.cat([observation, action], -1))


def networks() -> tuple[DeterministicActor, Critic]:
    bound = np.ones(ACTIONS)
    actor = DeterministicActor(WIDTH, -bound, bound, 0, NoNormaliser, [40, 30], "relu", noise=0.1)
    with torch.no_grad():
        actor.body.weights[-1].mul_(50.0)  # as learnt, so that actions are not all about 0
    return actor, Critic(WIDTH + ACTIONS, 1, [40, 30], "relu")


def transitions() -> Transitions:
    draw = partial(torch.randn, generator=torch.Generator().manual_seed(2))
    ended = torch.arange(ROWS)[:, None] % 3 == 0
    return Transitions(draw(ROWS, WIDTH), draw(ROWS, ACTIONS).tanh(), 3.0 * draw(ROWS, 1), draw(ROWS, WIDTH), ended)


def theirs(actor: DeterministicActor, critic: Critic) -> TorchRLLoss:
    loss = TorchRLLoss(
        TensorDictModule(nn.Sequential(actor.body, nn.Tanh()), ["observation"], ["action"]),
        ValueOperator(Joined(critic.body), ["observation", "action"]),
        loss_function="l2",
        delay_actor=True,
        delay_value=True,
    )
    loss.make_value_estimator(gamma=GAMMA)
    return loss


def as_tensordict(batch: Transitions) -> TensorDict:
    then = {"observation": batch.after, "reward": batch.reward, "done": batch.terminated}
    now = {"observation": batch.observation, "action": batch.action}
    following = TensorDict({**then, "terminated": batch.terminated}, batch_size=[ROWS])
    return TensorDict({**now, "next": following}, batch_size=[ROWS])


@pytest.mark.parametrize("saturation_cost", [0.0, 0.3])
def test_values_gradients_and_targets_equal_torchrl(saturation_cost: float) -> None:
    actor, critic = networks()
    own = DDPGLoss(actor, [critic], GAMMA, saturation_cost)
    other_actor, other_critic = networks()
    expected = theirs(other_actor, other_critic)
    follow, batch = SoftUpdate(expected, tau=TAU), transitions()
    pairs = ((own.actor_parameters, other_actor.body), (own.critic_parameters, other_critic.body))
    for _ in range(3):  # in the first round the targets are still the networks
        (critic_loss, value), actor_loss = own.differentiate_critics(batch), own.differentiate_actor(batch.observation)
        terms = expected(as_tensordict(batch))
        terms["loss_actor"] = (
            terms["loss_actor"] + saturation_cost * other_actor.body(batch.observation).square().mean()
        )
        torch.testing.assert_close(critic_loss, terms["loss_value"].detach(), rtol=1e-6, atol=1e-6)
        torch.testing.assert_close(actor_loss, terms["loss_actor"].detach(), rtol=1e-6, atol=1e-6)
        torch.testing.assert_close(value, terms["pred_value"].mean().detach(), rtol=1e-6, atol=1e-6)
        expected.zero_grad(set_to_none=True)
        (terms["loss_actor"] + terms["loss_value"]).backward()
        for flat, body in pairs:
            slopes = torch.cat([p.grad.flatten() for p in body.parameters() if p.grad is not None])
            assert slopes.abs().max() > 1e-2
            torch.testing.assert_close(flat.gradient, slopes, rtol=0.0, atol=1e-6)
            flat.vector -= 0.1 * flat.gradient
            with torch.no_grad():
                for parameter in body.parameters():
                    assert parameter.grad is not None
                    parameter.sub_(0.1 * parameter.grad)
        own.follow(TAU)
        follow.step()


def test_the_targets_go_on_from_a_state() -> None:
    made = [networks() for _ in range(2)]
    one, other = (DDPGLoss(actor, [critic], GAMMA, saturation_cost=0.0) for actor, critic in made)
    one.actor_parameters.vector += 1.0
    one.follow(TAU)
    other.load_state_dict(one.state_dict())
    assert torch.equal(*(each.differentiate_critics(transitions())[0] for each in (one, other)))
    one.follow(TAU)
    assert not torch.equal(one.state_dict()["late"], other.state_dict()["late"])
