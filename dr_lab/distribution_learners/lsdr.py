"""LSDR: learning the sweet-spot distribution range."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal

import numpy as np
import torch
from tensordict import TensorDict

from dr_lab.bounds import Count, NotNegative, Positive, above, at_least, at_most, require_bounds
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.play import undiscounted
from dr_lab.distribution_learners.distribution_learner import DistributionLearner
from dr_lab.distribution_learners.return_statistics import ReturnStatistics
from dr_lab.errors import ConfigError
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.divergence import divergence
from dr_lab.randomizers.randomizer import Density, Randomizer
from dr_lab.seeding import stream


class LSDR(DistributionLearner):
    """Draws p_φ(z) to contexts in which the policy does well, and holds it near a wide prior p(z).

    Ascends, with the score-function estimator over K contexts,

        L(φ) = (1/K) Σ_i Ĵ(z_i) log p_φ(z_i) − α KL(p‖p_φ),

    Ĵ the standardised return. z_i ~ p ("prior") also sees what p_φ has given up; z_i ~ p_φ ("learned") makes the first
    term the policy-gradient of E_{p_φ}[Ĵ]. KL(p‖p_φ) covers mass: it punishes giving up what p holds likely. Without
    it z_i ~ p_φ collapse to a point; z_i ~ p give up what returns less than the mean, but among the others, whose
    logits Adam raises alike however much they return, p_φ narrows slowly.

    Source: Mozifian, Gamboa Higuera, Meger, Dudek: Learning Domain Randomization Distributions for Training Robust
    Locomotion Policies, 2020, algorithms 1 and 2, equations 1 and 2.

    Args:
        randomizer: p_φ(z).
        seed: of the contexts that are tried.
        prior: makes p(z) over the same parameters.
        source: which of the two the tried contexts are drawn from.
        contexts: K, contexts tried in an iteration, one episode each.
        steps: M, steps of Adam on the same episodes.
        learning_rate: of Adam.
        alpha: α, weight of the divergence against standardised returns.
        return_rate: share of the newest batch in the averages of the returns.
        divergence_samples: draws for a divergence without closed form.
        every: control steps of training between two iterations of this, which wait for a batch of the policy's to end.

    Raises:
        ConfigError: φ is empty, p_φ has no density, p leaves the support of p_φ, or a number is out of its range.
    """

    def __init__(
        self,
        randomizer: Randomizer,
        seed: int,
        prior: Callable[[ContextSpace], Density],
        source: Literal["prior", "learned"],
        contexts: Annotated[int, at_least(2)],
        steps: Count,
        learning_rate: Positive,
        alpha: NotNegative,
        return_rate: Annotated[float, above(0.0), at_most(1.0)],
        divergence_samples: Count,
        every: Count = 1,
    ) -> None:
        super().__init__(randomizer)
        self.every = every
        self.contexts = contexts
        self.steps = steps
        self.learning_rate = learning_rate
        self.alpha = alpha
        self.return_rate = return_rate
        self.divergence_samples = divergence_samples
        require_bounds(self, "distribution_learner", LSDR)
        self.prior = prior(randomizer.space)
        self.density = _require_density(randomizer)
        self.tried_from = {"prior": self.prior, "learned": randomizer}[source]
        self.rng = stream(seed, "lsdr")
        self.statistics = ReturnStatistics(return_rate)
        self.optimiser = torch.optim.Adam(self._learnable(), lr=learning_rate)
        self._require_support()

    def update(self, batch: TensorDict, experience: Experience) -> Mapping[str, float]:
        """Try K contexts, then take M steps; gives entropy (where it has a closed form), divergence and returns."""
        del batch
        z = self.tried_from.sample([self.rng] * self.contexts)
        returns = undiscounted(experience.play(experience.policy, z))
        standardised = torch.from_numpy(self.statistics.standardise(returns))
        tried = torch.from_numpy(z)
        for _ in range(self.steps):
            score = (standardised * self.density.log_prob(tried)).mean()
            self.optimiser.zero_grad(set_to_none=True)
            (self.alpha * self._divergence() - score).backward()
            self.optimiser.step()
        with torch.no_grad():
            divergence_now = self._divergence().item()
        return {
            "divergence": divergence_now,
            "context_return": float(np.nanmean(returns)) if not np.isnan(returns).all() else np.nan,
            "infeasible": float(np.isnan(returns).mean()),
            **self._entropy(),
        }

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return super().state_dict() | {
            "optimiser": self.optimiser.state_dict(),
            "statistics": self.statistics.state_dict(),
            "rng": self.rng.bit_generator.state,
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        super().load_state_dict(state)
        self.optimiser.load_state_dict(state["optimiser"])
        self.statistics.load_state_dict(state["statistics"])
        self.rng.bit_generator.state = state["rng"]

    def _divergence(self) -> torch.Tensor:
        return divergence(self.prior, self.density, self.divergence_samples, self.rng)

    def _entropy(self) -> dict[str, float]:
        distribution = self.density.distribution()
        return {} if distribution is None else {"entropy": distribution.entropy().item()}

    def _learnable(self) -> list[torch.nn.Parameter]:
        parameters = list(self.randomizer.parameters())
        if not self.randomizer.space.names:
            raise ConfigError(
                "distribution_learner=lsdr has nothing to learn: the machine varies no parameter. Choose some, e.g. "
                "env/context=hopper/torso_size, or take distribution_learner=none."
            )
        if not any(parameter.numel() for parameter in parameters):
            raise ConfigError(
                f"distribution_learner=lsdr has nothing to learn in {type(self.randomizer).__name__}. "
                "Take randomizer=discrete, gaussian or mixture, or distribution_learner=none."
            )
        return parameters

    def _require_support(self) -> None:
        with torch.no_grad():
            if not torch.isfinite(self._divergence()):
                raise ConfigError(
                    "distribution_learner.prior reaches where the randomizer has no density. "
                    "Give both the same ranges: randomizer.ranges and distribution_learner.prior.ranges."
                )


def _require_density(randomizer: Randomizer) -> Density:
    if not isinstance(randomizer, Density):
        raise ConfigError(
            f"distribution_learner=lsdr asks how likely a context is, which {type(randomizer).__name__} does not know. "
            "Take randomizer=discrete, gaussian or mixture."
        )
    return randomizer
