"""SimOpt: adapting the distribution of simulations with a few episodes of the real machine."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, cast

import numpy as np
from tensordict import TensorDict
from torch.distributions import kl_divergence

from dr_lab.bounds import Count, Natural, Positive, at_least, require_bounds
from dr_lab.collectors.collector import Policy
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.play import outcomes
from dr_lab.distribution_learners.distribution_learner import DistributionLearner
from dr_lab.distribution_learners.simopt.discrepancy import Discrepancy
from dr_lab.distribution_learners.simopt.relative_entropy import (
    Gaussian,
    bounded_fit,
    sample_weights,
    temperature,
)
from dr_lab.envs.environment import Environment
from dr_lab.envs.setting import Setting, require_mujoco
from dr_lab.envs.slots import Starts
from dr_lab.errors import ConfigError
from dr_lab.randomizers.gaussian import GaussianRandomizer
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.seeding import stream
from dr_lab.targets.target import Target
from dr_lab.trajectory import Array

_Pair = tuple[TensorDict, TensorDict]


class SimOpt(DistributionLearner):
    """Moves p_φ(z) = N(μ, Σ) to contexts in which the policy moves the model as it moves the real machine.

    An iteration, once the policy has been trained for `every` control steps more:

    1. The policy, without exploration, is played on the target, from a few starts of the task.
    2. It is played in the model from the same starts, in contexts drawn from p_φ; c(z) is the mean discrepancy over
       the starts. A context that is infeasible costs as much as the worst that is not.
    3. φ moves by relative entropy policy search, KL(p_φ′‖p_φ) ≤ ε. Steps 2 and 3 are repeated with the same real
       episodes.

    Source: Chebotar et al. 2019, algorithm 1, equations 3 and 4.

    Args:
        randomizer: p_φ(z), Gaussian.
        seed: of starts and contexts.
        setting: machine and task, which MuJoCo plays.
        target: makes the real machine.
        discrepancy: D.
        rollouts: episodes of the target in an iteration.
        samples: contexts that are tried in an update.
        updates: of φ in an iteration.
        max_kl: ε.
        least_temperature: lowest temperature of the samples' weights.
        warm_up: turns of `every` control steps that pass before the first iteration.
        every: control steps of training between two iterations, which wait for a batch of the policy's to end.

    Raises:
        ConfigError: p_φ is no Gaussian, another engine plays the environment, the target is of another machine, or a
            number is out of its range.
        UnknownNameError: the discrepancy measures what the machine does not have.
    """

    def __init__(
        self,
        randomizer: Randomizer,
        seed: int,
        setting: Environment,
        target: Callable[[Setting], Target],
        discrepancy: Discrepancy,
        rollouts: Count,
        samples: Annotated[int, at_least(2)],
        updates: Count,
        max_kl: Positive,
        least_temperature: Positive,
        warm_up: Natural,
        every: Count,
    ) -> None:
        super().__init__(randomizer)
        self.rollouts, self.samples, self.updates = rollouts, samples, updates
        self.max_kl, self.least_temperature, self.warm_up, self.every = max_kl, least_temperature, warm_up, every
        require_bounds(self, "distribution_learner", SimOpt)
        self._gaussian = _require_gaussian(randomizer)
        self._setting = require_mujoco(setting, "distribution_learner=simopt")
        self._compiled = self._setting.model.nominal()
        discrepancy.measured(self._compiled, self._setting.task.measured)
        self._discrepancy, self._target = discrepancy, target(self._setting)
        self.rng = stream(seed, "simopt")
        self._turns = 0

    def update(self, batch: TensorDict, experience: Experience) -> Mapping[str, float]:
        """An iteration; gives the discrepancy before its first update, and the largest divergence of an update."""
        del batch
        self._turns += 1
        if self._turns <= self.warm_up:
            return {}
        starts = self._starts()
        real = self._target.play(experience.deployed, starts, self.rollouts)
        steps = [self._step(experience, real, starts) for _ in range(self.updates)]
        return {
            "discrepancy": steps[0]["discrepancy"],
            "divergence": max(each["divergence"] for each in steps),
            "temperature": steps[-1]["temperature"],
            "infeasible": float(np.mean([each["infeasible"] for each in steps])),
            "target_steps": float(real["mask"].sum()),
        }

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return super().state_dict() | {"rng": self.rng.bit_generator.state, "turns": self._turns}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        super().load_state_dict(state)
        self.rng.bit_generator.state = state["rng"]
        self._turns = state["turns"]

    def _step(self, experience: Experience, real: TensorDict, starts: Starts) -> dict[str, float]:
        """One update of φ."""
        z = self.randomizer.sample([self.rng] * self.samples)
        costs = self._costs(experience, experience.deployed, z, real, starts)
        known = np.isfinite(costs)
        infeasible = float(np.mean(~known))
        if not known.any():
            return {"discrepancy": np.nan, "divergence": 0.0, "temperature": np.nan, "infeasible": infeasible}
        costs = np.where(known, costs, costs[known].max())
        eta = temperature(costs, self.max_kl, self.least_temperature)
        before, old = self._gaussian.distribution(), Gaussian(*self._gaussian.moments())
        self._gaussian.set_moments(*bounded_fit(old, z, sample_weights(costs, eta), self.max_kl))
        moved = kl_divergence(self._gaussian.distribution(), before).item()
        mean = float(costs[known].mean())
        return {"discrepancy": mean, "divergence": moved, "temperature": eta, "infeasible": infeasible}

    def _costs(self, experience: Experience, policy: Policy, z: Array, real: TensorDict, starts: Starts) -> Array:
        """Mean discrepancy of each context over the starts, shape (samples,); NaN where one diverges."""
        qpos, qvel = (np.tile(each, (self.samples, 1)) for each in starts)
        played = experience.play(policy, z.repeat(self.rollouts, axis=0), (qpos, qvel))
        _, infeasible = outcomes(played)
        pairs = ((real[k], played[k :: self.rollouts]) for k in range(self.rollouts))
        seen = self._setting.task.measured
        costs = np.stack([self._discrepancy(self._compiled, *cast(_Pair, pair), seen) for pair in pairs])
        return np.where(infeasible.reshape(self.samples, -1).any(1), np.nan, costs.mean(0))

    def _starts(self) -> Starts:
        each = [self._setting.task.start(self.rng, self._compiled) for _ in range(self.rollouts)]
        qpos, qvel = zip(*each, strict=True)
        return np.stack(qpos), np.stack(qvel)


def _require_gaussian(randomizer: Randomizer) -> GaussianRandomizer:
    if not isinstance(randomizer, GaussianRandomizer):
        raise ConfigError(
            f"distribution_learner=simopt moves a Gaussian, which {type(randomizer).__name__} is not. Take "
            "randomizer=gaussian or from_run."
        )
    return randomizer
