"""TD3's losses, which are DDPG's with a target that is harder to overestimate."""

from collections.abc import Sequence

import torch
from torch import Tensor

from dr_lab.algorithms.ddpg.loss import DDPGLoss
from dr_lab.networks.critic import Critic
from dr_lab.networks.deterministic_actor import DeterministicActor


class TD3Loss(DDPGLoss):
    """L_Q = Σᵢ E[(Qᵢ(o, a) − y)²] with y = r + γ minᵢ Q'ᵢ(o', ã) and ã = μ'(o') + ε within ±1, ε = N(0, σ²) within ±c.

    The lesser of two estimates does not err upward as one does whose largest value the actor seeks, and the mean about
    μ' does not follow peaks of Q'. Equal to TorchRL's `TD3Loss` for the same ε, in value and gradient.

    Source: Fujimoto et al. 2018, algorithm 1.

    Args:
        actor: its body is f of μ = tanh ∘ f.
        critics: Q₁ and Q₂.
        gamma: γ, discount per control step.
        saturation_cost: as `DDPGLoss`.
        noise: σ, for actions scaled to ±1.
        clip: c, likewise.
        generator: random numbers of ε.
    """

    def __init__(
        self,
        actor: DeterministicActor,
        critics: Sequence[Critic],
        gamma: float,
        saturation_cost: float,
        *,
        noise: float,
        clip: float,
        generator: torch.Generator,
    ) -> None:
        super().__init__(actor, critics, gamma, saturation_cost)
        self._noise, self._clip, self._generator = noise, clip, generator

    def _late_action(self, observation: Tensor) -> Tensor:
        action = super()._late_action(observation)
        noise = torch.empty(action.shape).normal_(0.0, self._noise, generator=self._generator)
        return action.add_(noise.clamp_(-self._clip, self._clip).to(action.device)).clamp_(-1.0, 1.0)
