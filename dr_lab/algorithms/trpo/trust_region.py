"""A step as far as the divergence from the policy that acted allows."""

from collections.abc import Mapping
from math import sqrt

import torch
from torch import Tensor

from dr_lab.algorithms.trpo.conjugate_gradients import Product, conjugate_gradients
from dr_lab.algorithms.trpo.divergence_product import divergence_product
from dr_lab.algorithms.trpo.policy_rows import PolicyRows, mean, mean_divergence, ratio
from dr_lab.algorithms.trpo.policy_step import Linearised, PolicyAt, PolicyStep
from dr_lab.bounds import Count, NotNegative, Positive, Share, require_bounds
from dr_lab.networks.flat import FlatParameters
from dr_lab.networks.gaussian import Gaussian


class TrustRegion(PolicyStep):
    """Minimises L(θ) = −E[ρ A] under E[KL(π_acted‖π_θ)] ≤ δ, to first and second order, then by a line search.

    The direction is x = −(H + c)⁻¹ ∇L by conjugate gradients, H the Hessian of the divergence; the first length makes
    ½ xᵀ (H + c) x = δ, and shrinks until L falls and the divergence itself is at most δ. Where it never does, θ stays.

    H costs most of the time, and may come from fewer rows than all else: those that follow each other in an episode say
    nearly the same. Through an adaptation it is that of the parameters which such rows adapt.

    Source: Schulman et al. 2015, appendix C.

    Args:
        parameters: θ.
        max_kl: δ.
        iterations: of conjugate gradients.
        tolerance: of their residual, as a share of |∇L|, at which they end before.
        damping: c.
        hessian_every: every so many-th row makes H; 1 takes all.
        trials: of the line search.
        shrink: factor of the length from one trial to the next.

    Raises:
        ConfigError: a number is out of its range.
    """

    def __init__(
        self,
        parameters: FlatParameters,
        max_kl: Positive,
        iterations: Count,
        tolerance: NotNegative,
        damping: NotNegative,
        hessian_every: Count,
        trials: Count,
        shrink: Share,
    ) -> None:
        super().__init__(parameters)
        self.max_kl, self.iterations, self.tolerance, self.damping = max_kl, iterations, tolerance, damping
        self.hessian_every, self.trials, self.shrink = hessian_every, trials, shrink
        require_bounds(self, "algorithm.step", TrustRegion)

    def loss(self, policy: Gaussian, rows: PolicyRows) -> Tensor:
        """−E[ρ A]."""
        return -mean(ratio(policy, rows) * rows.advantage, rows)

    def __call__(self, policy_at: PolicyAt, rows: PolicyRows) -> Mapping[str, float]:
        """One step; `kl` and `improvement` of −L are those of the step that was taken, 0 where none was."""
        near = policy_at.linearised(self.parameters.vector)
        loss, slope = self.differentiate(near, rows)
        hessian = self._hessian(policy_at, near, rows)
        solved = conjugate_gradients(lambda v: hessian(v) + self.damping * v, -slope, self.iterations, self.tolerance)
        curvature = float(solved.found @ solved.image)
        figures = {"gradient": slope.norm().item()}
        if not curvature > 0.0:  # also NaN; there is no slope, or no direction of descent
            return {**figures, "kl": 0.0, "improvement": 0.0, "trials": 0.0}
        longest = sqrt(2.0 * self.max_kl / curvature) * solved.found
        return {**figures, **self._search(policy_at, rows, loss, longest)}

    def _hessian(self, policy_at: PolicyAt, near: Linearised, rows: PolicyRows) -> Product:
        if self.hessian_every == 1:
            return divergence_product(near, rows)
        fewer = policy_at.thinned(self.hessian_every)
        return divergence_product(fewer.linearised(self.parameters.vector), rows.thinned(self.hessian_every))

    @torch.no_grad()
    def _search(self, policy_at: PolicyAt, rows: PolicyRows, loss: float, step: Tensor) -> Mapping[str, float]:
        begin = self.parameters.vector.clone()
        for trial in range(self.trials):
            candidate = begin + self.shrink**trial * step
            policy = policy_at(candidate)
            found, kl = self.loss(policy, rows).item(), mean_divergence(policy, rows).item()
            if found < loss and kl <= self.max_kl:
                self.parameters.vector.copy_(candidate)
                return {"kl": kl, "improvement": loss - found, "trials": trial + 1.0}
        return {"kl": 0.0, "improvement": 0.0, "trials": float(self.trials)}
