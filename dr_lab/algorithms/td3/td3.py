"""Twin delayed deep deterministic policy gradient."""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import torch
from torch import Tensor

from dr_lab.algorithms.algorithm import Interface
from dr_lab.algorithms.ddpg.ddpg import DDPG
from dr_lab.algorithms.ddpg.loss import Transitions
from dr_lab.algorithms.td3.loss import TD3Loss
from dr_lab.bounds import Count, NotNegative, require_bounds
from dr_lab.networks.critic import Critic


class TD3(DDPG):
    """DDPG with two critics, of which the lesser is believed, and an actor that waits for them.

    Source: Fujimoto et al. 2018.

    Args:
        interface: what the policy is connected to.
        seed: of DDPG, and of what the target adds to actions.
        target_noise: standard deviation of what the target adds to actions scaled to ±1.
        target_clip: largest that is added.
        actor_every: steps of the critics for each step of the actor and the targets.
        ddpg: the other arguments of `DDPG`; `critic` makes both critics.

    Raises:
        ConfigError: a number is out of its range.
    """

    _CRITICS: ClassVar[Sequence[str]] = ("critic", "second_critic")

    def __init__(
        self,
        interface: Interface,
        seed: int,
        *,
        target_noise: NotNegative,
        target_clip: NotNegative,
        actor_every: Count,
        **ddpg: Any,  # noqa: ANN401 (DDPG's own)
    ) -> None:
        self.target_noise, self.target_clip, self.actor_every = target_noise, target_clip, actor_every
        require_bounds(self, "algorithm", TD3)
        super().__init__(interface, seed, **ddpg)
        self.steps = 0

    def _made_loss(self, critics: Sequence[Critic]) -> TD3Loss:
        return TD3Loss(
            self.actor,
            critics,
            self.gamma,
            self.saturation_cost,
            noise=self.target_noise,
            clip=self.target_clip,
            generator=self.generator,
        )

    def _step(self, batch: Transitions) -> Tensor:
        critic_loss, value = self.loss.differentiate_critics(batch)
        self.critic_adam.step(self.critic_rate)
        self.steps += 1
        if self.steps % self.actor_every == 0:
            self._step_actor(batch.observation)
        return torch.stack([critic_loss, value])

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return super().state_dict() | {"steps": self.steps}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        super().load_state_dict(state)
        self.steps = state["steps"]
