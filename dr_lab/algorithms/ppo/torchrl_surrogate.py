"""PPO's loss as TorchRL has it."""

from tensordict import TensorDict
from tensordict.nn import TensorDictModule
from torch import Tensor, nn
from torch.distributions import Independent, Normal
from torchrl.modules import ProbabilisticActor, ValueOperator
from torchrl.objectives import ClipPPOLoss

from dr_lab.algorithms.ppo.surrogate import PolicySamples, Surrogate, Terms
from dr_lab.networks.critic import Critic
from dr_lab.networks.gaussian_actor import GaussianActor


class TorchRLSurrogate(Surrogate):
    """`torchrl.objectives.ClipPPOLoss` on the same networks.

    Args: as `Surrogate`.
    """

    def __init__(
        self, actor: GaussianActor, critic: Critic, clip: float, entropy_weight: float, critic_weight: float
    ) -> None:
        super().__init__(actor, critic, clip, entropy_weight, critic_weight)
        head = TensorDictModule(_Head(actor), in_keys=["observation"], out_keys=["loc", "scale"])
        policy = ProbabilisticActor(
            head,
            in_keys=["loc", "scale"],
            distribution_class=_IndependentNormal,
            return_log_prob=True,
        )
        self._loss = ClipPPOLoss(
            policy,
            ValueOperator(critic.body, in_keys=["observation"]),
            clip_epsilon=clip,
            entropy_bonus=True,
            entropy_coeff=entropy_weight,
            critic_coeff=critic_weight,
            loss_critic_type="l2",
            normalize_advantage=True,
            functional=False,
        )

    def differentiate(self, samples: PolicySamples) -> Terms:
        """The loss and its gradient."""
        fields = {
            "observation": samples.observation,
            "action": samples.action,
            "action_log_prob": samples.log_prob,
            "advantage": samples.advantage.unsqueeze(-1),
            "value_target": samples.target.unsqueeze(-1),
        }
        out = self._loss(TensorDict(fields, batch_size=[len(samples.target)]))
        terms = Terms(out["loss_objective"], out["loss_entropy"], out["loss_critic"])
        self.actor_parameters.differentiate(terms.objective + terms.entropy)
        self.critic_parameters.differentiate(terms.critic)
        return Terms(*(term.detach() for term in terms))


class _Head(nn.Module):
    """Mean and standard deviation of actions scaled to ±1, for observations that are normalised already."""

    def __init__(self, actor: GaussianActor) -> None:
        super().__init__()
        self.body = actor.body
        self.log_std = actor.log_std

    def forward(self, observation: Tensor) -> tuple[Tensor, Tensor]:
        mean = self.body(observation)
        return mean, self.log_std.exp().expand_as(mean)


class _IndependentNormal(Independent):
    def __init__(self, loc: Tensor, scale: Tensor) -> None:
        super().__init__(Normal(loc, scale), 1)
