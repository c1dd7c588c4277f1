"""Some steps of Adam on PPO's clipped objective, with all rows at once."""

from collections.abc import Mapping
from typing import Annotated, Any

import torch
from torch import Tensor

from dr_lab.algorithms.ppo.clipped import clipped
from dr_lab.algorithms.trpo.policy_rows import PolicyRows, mean, mean_divergence, ratio
from dr_lab.algorithms.trpo.policy_step import PolicyAt, PolicyStep
from dr_lab.bounds import Count, Limit, NotNegative, Positive, above, require_bounds
from dr_lab.networks.adam import Adam, clip_norm
from dr_lab.networks.flat import FlatParameters
from dr_lab.networks.gaussian import Gaussian


class ClippedStep(PolicyStep):
    """Descends L(θ) = −E[min(ρA, clip(ρ, 1 ± ε)A)].

    Source: Schulman et al. 2017, equation 7; through an adaptation, Rothfuss et al. 2019.

    Args:
        parameters: θ.
        clip: ε.
        epochs: steps of Adam.
        rate: of these.
        max_gradient: largest norm of a gradient.
        max_kl: E[KL(π_acted‖π_θ)] at which the rest of the epochs is left out; None never.
        adam_epsilon: ε of Adam.

    Raises:
        ConfigError: a number is out of its range.
    """

    def __init__(
        self,
        parameters: FlatParameters,
        clip: Positive,
        epochs: Count,
        rate: Positive,
        max_gradient: Limit,
        max_kl: Annotated[float | None, above(0.0)],
        adam_epsilon: NotNegative,
    ) -> None:
        super().__init__(parameters)
        self.clip, self.epochs, self.rate = clip, epochs, rate
        self.max_gradient, self.max_kl, self.adam_epsilon = max_gradient, max_kl, adam_epsilon
        require_bounds(self, "algorithm.step", ClippedStep)
        self.adam = Adam(parameters, adam_epsilon)

    def loss(self, policy: Gaussian, rows: PolicyRows) -> Tensor:
        """−E[min(ρA, clip(ρ, 1 ± ε)A)]."""
        return -mean(clipped(ratio(policy, rows), rows.advantage, self.clip), rows)

    def __call__(self, policy_at: PolicyAt, rows: PolicyRows) -> Mapping[str, float]:
        """All epochs; `kl` and `improvement` of −L are those of all steps that were taken, the last one included."""
        losses, norms = list[float](), list[float]()
        for _ in range(self.epochs):
            near = policy_at.linearised(self.parameters.vector)
            if self.max_kl is not None and mean_divergence(near.policy, rows).item() > self.max_kl:
                break
            loss, slope = self.differentiate(near, rows)
            losses.append(loss)
            norms.append(slope.norm().item())
            self.parameters.gradient.copy_(slope)
            clip_norm([self.parameters.gradient], self.max_gradient)
            self.adam.step(self.rate)
        with torch.no_grad():
            policy = policy_at(self.parameters.vector)
            kl, loss = mean_divergence(policy, rows).item(), self.loss(policy, rows).item()
        return {"gradient": norms[0], "kl": kl, "improvement": losses[0] - loss, "epochs": float(len(losses))}

    def state_dict(self) -> dict[str, Any]:
        """The moments of Adam."""
        return {"adam": self.adam.state_dict()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.adam.load_state_dict(state["adam"])
