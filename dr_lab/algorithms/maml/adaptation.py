"""What adapting a policy to a task means."""

from collections.abc import Callable, Mapping, Sequence
from typing import Annotated

from torch import Tensor
from torch.func import grad, vmap

from dr_lab.algorithms.maml.inner_loss import InnerLoss
from dr_lab.algorithms.maml.inner_rate import InnerRate
from dr_lab.algorithms.trpo.policy_rows import PolicyRows
from dr_lab.bounds import Count, at_least, at_most, require_bounds
from dr_lab.networks.gaussian import Gaussian
from dr_lab.networks.gaussian_actor import GaussianActor

Parameters = Mapping[str, Tensor]
"""Of a policy, as ``dict(actor.named_parameters())`` names them; of T tasks with a leading dimension each."""


class Adaptation:
    """θ_i ← θ_i − α ∘ ∇L_i(θ_i) in every task i, `updates` times, each on episodes that θ_i has played itself.

    Source: Finn et al. 2017, algorithm 3.

    Args:
        actor: the policy.
        loss: L.
        rate: makes α, from the policy.
        updates: steps.
        order: of the derivatives by which what comes of θ is followed back to it: 2 goes through ∇L; 1 takes ∇L for a
            constant, so that ∂θ_i/∂θ = 1.

    Raises:
        ConfigError: a number is out of its range.
    """

    def __init__(
        self,
        actor: GaussianActor,
        loss: InnerLoss,
        rate: Callable[[GaussianActor], InnerRate],
        updates: Count,
        order: Annotated[int, at_least(1), at_most(2)],
    ) -> None:
        self.updates, self.order = updates, order
        require_bounds(self, "algorithm.adaptation", Adaptation)
        self.actor, self.loss, self.rate = actor, loss, rate(actor)

    def beginning(self, parameters: Parameters, tasks: int) -> Parameters:
        """The same θ for each of T tasks."""
        return {name: value.expand(tasks, *value.shape) for name, value in parameters.items()}

    def updated(self, parameters: Parameters, rates: Parameters, rows: PolicyRows) -> Parameters:
        """θ_i after one update, of all tasks at once.

        Args:
            parameters: θ_i, T of each.
            rates: α.
            rows: of T tasks.
        """

        def of_one(own: Parameters, seen: PolicyRows) -> Parameters:
            slopes = grad(lambda moved: self.loss(self.actor.distribution(moved, seen.observation), seen))(own)
            if self.order == 1:
                slopes = {name: slope.detach() for name, slope in slopes.items()}
            return {name: value - rates[name] * slopes[name] for name, value in own.items()}

        return vmap(of_one)(parameters, rows)

    def adapted(self, parameters: Parameters, rates: Parameters, phases: Sequence[PolicyRows]) -> Parameters:
        """θ_i after one update on each of some phases.

        Args:
            parameters: θ.
            rates: α.
            phases: rows of T tasks, played before the first update, before the second, …
        """
        found = self.beginning(parameters, len(phases[0].weight))
        for rows in phases:
            found = self.updated(found, rates, rows)
        return found

    def acting(self, parameters: Parameters, observation: Tensor) -> Gaussian:
        """What acts in T tasks, μ of shape (T, R, nu), log σ of shape (T, 1, nu).

        Args:
            parameters: θ_i, T of each.
            observation: normalised, shape (T, R, o).
        """
        policy = vmap(self.actor.distribution)(parameters, observation)
        return Gaussian(policy.mean, policy.log_std.unsqueeze(1))
