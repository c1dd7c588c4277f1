"""Particles that pay for acting otherwise than those of a finished run."""

from collections.abc import Mapping, Sequence
from typing import Any

import torch
from torch import Tensor

from dr_lab.bounds import NotNegative, require_bounds
from dr_lab.distribution_learners.svpg.particles import Particles
from dr_lab.distribution_learners.svpg.stacked import Stacked
from dr_lab.networks.gaussian import Gaussian, divergence


class PriorParticles(Particles):
    """Particles, each of which has a frozen one of a finished run beside it, μ⁰.

    A step costs c·KL(μ(·|u) ‖ μ⁰(·|u)), so that each particle climbs E Σₜ γᵗ (rₜ − c·KLₜ). That includes what the
    divergence itself depends on θ, which is known in closed form and not left to the score function.

    Source: Mehta, thesis, 2020, equation 2.3.4, which prints + α·KL; a penalty is what its text describes.

    Args: as `Particles`, and
        penalty: c, in units of reward; the thesis gives no number.

    Attributes:
        prior: μ⁰; None until a finished run is known.

    Raises:
        ConfigError: a number is out of its range.
    """

    def __init__(
        self,
        count: int,
        size: int,
        generator: torch.Generator,
        hidden: Sequence[int],
        gamma: float,
        penalty: NotNegative,
    ) -> None:
        super().__init__(count, size, generator, hidden, gamma)
        self.penalty = penalty
        require_bounds(self, "distribution_learner.svpg.particles", PriorParticles)
        self.prior: Stacked | None = None

    def cost(self, u: Tensor) -> Tensor:
        """c·KL(μ(·|u) ‖ μ⁰(·|u)) at points (N, k, n), shape (N, k); nothing without a prior."""
        if self.prior is None:
            return super().cost(u)
        with torch.no_grad():
            before = Gaussian(*self.prior(u).chunk(2, -1))
        return self.penalty * divergence(self.policy(u), before)

    def inherit(self, state: Mapping[str, Any]) -> None:
        """Begin as the particles of another run, which are the prior from now on.

        Their critics are not taken over: what they have learnt to expect are other rewards.
        """
        self.actors.load_state_dict(state["actors"])
        self._keep(state["actors"])

    def state_dict(self) -> dict[str, Any]:
        """All parameters, those of the prior included."""
        return super().state_dict() | {"prior": None if self.prior is None else self.prior.state_dict()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        super().load_state_dict(state)
        if state["prior"] is not None:
            self._keep(state["prior"])

    def _keep(self, actors: Mapping[str, Any]) -> None:
        """Make a frozen copy of actors the prior."""
        self.prior = self.actors.twin()
        self.prior.load_state_dict(actors)
