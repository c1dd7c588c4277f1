"""TD3's written-out losses equal TorchRL's `TD3Loss` in value and gradient, and its target is the lesser of two."""

import numpy as np
import torch
from tensordict import TensorDict
from tensordict.nn import TensorDictModule
from torch import Tensor, nn
from torchrl.data import Bounded
from torchrl.modules import ValueOperator
from torchrl.objectives import SoftUpdate
from torchrl.objectives import TD3Loss as TorchRLLoss

from dr_lab.algorithms.ddpg.loss import Transitions
from dr_lab.algorithms.td3.loss import TD3Loss
from dr_lab.networks.critic import Critic
from dr_lab.networks.deterministic_actor import DeterministicActor
from dr_lab.networks.normaliser import NoNormaliser

WIDTH, ACTIONS, ROWS, GAMMA, NOISE, CLIP, NOISE_SEED = 8, 2, 64, 0.97, 0.4, 0.5, 5


def networks(last_bias: float = 0.0) -> tuple[DeterministicActor, list[Critic]]:
    bound = np.ones(ACTIONS)
    actor = DeterministicActor(WIDTH, -bound, bound, 0, NoNormaliser, [40, 30], "relu", noise=0.1)
    critics = [Critic(WIDTH + ACTIONS, seed, [40, 30], "relu") for seed in (1, 2)]
    with torch.no_grad():
        actor.body.weights[-1].mul_(50.0)  # as learnt, so that actions are not all about 0
        critics[1].body.biases[-1].add_(last_bias)
    return actor, critics


def made(actor: DeterministicActor, critics: list[Critic], noise: float = NOISE) -> TD3Loss:
    generator = torch.Generator().manual_seed(NOISE_SEED)
    return TD3Loss(actor, critics, GAMMA, 0.0, noise=noise, clip=CLIP, generator=generator)


def transitions() -> Transitions:
    generator = torch.Generator().manual_seed(2)
    wide, narrow, reward = (torch.randn(ROWS, k, generator=generator) for k in (2 * WIDTH, ACTIONS, 1))
    ended = torch.arange(ROWS)[:, None] % 3 == 0
    return Transitions(wide[:, :WIDTH], narrow.tanh(), 3.0 * reward, wide[:, WIDTH:], ended)


class Joined(nn.Module):
    def __init__(self, body: nn.Module) -> None:
        super().__init__()
        self.body = body

    def forward(self, observation: Tensor, action: Tensor) -> Tensor:
        return self.body(torch.cat([observation, action], -1))


def theirs(actor: DeterministicActor, critics: list[Critic], batch: Transitions) -> tuple[Tensor, Tensor, list[Tensor]]:
    """Losses of critics and actor, and the gradients of the actor and of each critic."""
    names = ["observation", "action"]
    loss = TorchRLLoss(
        TensorDictModule(nn.Sequential(actor.body, nn.Tanh()), ["observation"], ["action"]),
        [ValueOperator(Joined(critic.body), names) for critic in critics],
        action_spec=Bounded(-1.0, 1.0, shape=torch.Size([ACTIONS])),
        policy_noise=NOISE,
        noise_clip=CLIP,
        loss_function="l2",
    )
    loss.make_value_estimator(gamma=GAMMA)
    SoftUpdate(loss, tau=0.1)  # without one it warns
    ends = {"done": batch.terminated, "terminated": batch.terminated}
    following = TensorDict({"observation": batch.after, "reward": batch.reward, **ends}, batch_size=[ROWS])
    now = {"observation": batch.observation, "action": batch.action}
    torch.manual_seed(NOISE_SEED)
    terms = loss(TensorDict({**now, "next": following}, batch_size=[ROWS]))
    (terms["loss_actor"] + terms["loss_qvalue"]).backward()
    own, both = (
        [p.grad for p in parameters.flatten_keys(".").values()]
        for parameters in (loss.actor_network_params, loss.qvalue_network_params)
    )
    each = [[slopes[k] for slopes in both] for k in (0, 1)]
    gradients = [torch.cat([slope.flatten() for slope in slopes]) for slopes in (own, *each)]
    return terms["loss_qvalue"].detach(), terms["loss_actor"].detach(), gradients


def test_values_and_gradients_equal_torchrl() -> None:
    own, batch = made(*networks()), transitions()
    (critic_loss, _), actor_loss = own.differentiate_critics(batch), own.differentiate_actor(batch.observation)
    expected_critic, expected_actor, (actor, *critics) = theirs(*networks(), batch)
    torch.testing.assert_close(critic_loss, expected_critic, rtol=1e-5, atol=1e-6)
    torch.testing.assert_close(actor_loss, expected_actor, rtol=1e-5, atol=1e-6)
    assert min(slopes.abs().max() for slopes in (actor, *critics)) > 1e-2
    torch.testing.assert_close(own.actor_parameters.gradient, actor, rtol=0.0, atol=1e-5)
    torch.testing.assert_close(own.critic_parameters.gradient, torch.cat(critics), rtol=0.0, atol=1e-5)


def test_the_target_is_the_lesser_value_without_noise() -> None:
    actor, critics = networks(last_bias=-3.0)
    batch = transitions()
    with torch.no_grad():
        then = torch.cat([batch.after, actor.body(batch.after).tanh()], 1)
        now = torch.cat([batch.observation, batch.action], 1)
        late = torch.minimum(*(critic.body(then) for critic in critics))
        target = batch.reward + GAMMA * late * ~batch.terminated
        expected = sum((critic.body(now) - target).square().mean() for critic in critics)
    assert (late < critics[0].body(then)).any()
    found, _ = made(actor, critics, noise=0.0).differentiate_critics(batch)
    torch.testing.assert_close(found, expected)
