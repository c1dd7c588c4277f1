"""SimOpt: adapting the distribution of simulations with a few episodes of the real machine."""

from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, cast

import numpy as np
from tensordict import TensorDict
from torch.distributions import kl_divergence

from dr_lab.bounds import Count, Natural, Positive, at_least, require_bounds
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.play import outcomes
from dr_lab.distribution_learners.distribution_learner import DistributionLearner
from dr_lab.distribution_learners.simopt.comparison import comparisons
from dr_lab.distribution_learners.simopt.discrepancy import Discrepancy
from dr_lab.distribution_learners.simopt.relative_entropy import (
    Gaussian,
    bounded_fit,
    sample_weights,
    temperature,
)
from dr_lab.distribution_learners.simopt.trial import Trial
from dr_lab.envs.environment import Environment
from dr_lab.envs.setting import Setting, require_mujoco
from dr_lab.errors import ConfigError
from dr_lab.randomizers.gaussian import GaussianRandomizer
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.recorders.training import Comparison
from dr_lab.seeding import stream
from dr_lab.targets.target import Target
from dr_lab.trajectory import Array

_DRAWN = 6  # contexts whose courses are shown


class SimOpt(DistributionLearner):
    """Moves p_φ(z) = N(μ, Σ) to contexts in which the policy moves the model as it moves the real machine.

    An iteration, once the policy has been trained for `every` control steps more:

    1. The policy, without exploration, is played on the target, from a few starts of the task. Of recorded logs as many
       episodes are taken, with their own starts and commands.
    2. The policy is played in the model from the same starts, or what was commanded, in contexts drawn from p_φ; c(z)
       is the mean discrepancy over the starts. A context that is infeasible costs as much as the worst that is not.
    3. φ moves by relative entropy policy search, KL(p_φ′‖p_φ) ≤ ε. Steps 2 and 3 are repeated with the same real
       episodes.

    Source: Chebotar et al. 2019, algorithm 1, equations 3 and 4.

    Limits: where the randomizer clips, which the paper does not do, a context counts as what it was moved to. μ then
    stays within the bounds, and a Gaussian that reaches beyond them narrows and moves inward where the episodes say
    nothing: with μ one σ from a bound, to about σ/2 in twelve updates.

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
        warm_up: turns of `every` control steps that pass before the turn that ends with the first iteration.
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
        self.first = (warm_up + 1) * every
        self._gaussian = _require_gaussian(randomizer)
        self._setting = require_mujoco(setting, "distribution_learner=simopt")
        self._compiled = self._setting.model.nominal()
        self._measured = discrepancy.measured(self._compiled, self._setting.task.measured)
        self._discrepancy, self._target = discrepancy, target(self._setting)
        self.rng = stream(seed, "simopt")
        self._compared: Sequence[Comparison] = ()

    def update(self, batch: TensorDict, experience: Experience) -> Mapping[str, float]:
        """An iteration; gives the discrepancy before its first update and at the mean after its last.

        Also the largest divergence of an update, the last temperature, the share of infeasible contexts and the control
        steps of the target's episodes.
        """
        del batch
        trial = self._trial(experience)
        tried, steps = zip(*(self._step(experience, trial) for _ in range(self.updates)), strict=True)
        return {
            "discrepancy": steps[0]["discrepancy"],
            "discrepancy_of_mean": self._look(experience, trial, tried[-1][:_DRAWN]),
            "divergence": max(each["divergence"] for each in steps),
            "temperature": steps[-1]["temperature"],
            "infeasible": float(np.mean([each["infeasible"] for each in steps])),
            "target_steps": float(trial.real["mask"].sum()),
        }

    def compared(self) -> Sequence[Comparison]:
        """The episode of the newest iteration in which the model at the mean differs most from the target."""
        found, self._compared = self._compared, ()
        return found

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return super().state_dict() | {"rng": self.rng.bit_generator.state}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        super().load_state_dict(state)
        self.rng.bit_generator.state = state["rng"]

    def _trial(self, experience: Experience) -> Trial:
        """What this iteration has of the target."""
        if not self._target.drivable:
            return Trial.of_logs(self._target, self.rollouts)
        each = [self._setting.task.start(self.rng, self._compiled) for _ in range(self.rollouts)]
        qpos, qvel = zip(*each, strict=True)
        return Trial.of_policy(self._target, experience.deployed, (np.stack(qpos), np.stack(qvel)))

    def _step(self, experience: Experience, trial: Trial) -> tuple[Array, dict[str, float]]:
        """One update of φ; gives the contexts that were tried, too."""
        z = self.randomizer.sample([self.rng] * self.samples)
        costs = self._costs(trial, trial.simulated(experience, z))
        known = np.isfinite(costs)
        infeasible = float(np.mean(~known))
        if not known.any():
            return z, {"discrepancy": np.nan, "divergence": 0.0, "temperature": np.nan, "infeasible": infeasible}
        costs = np.where(known, costs, costs[known].max())
        eta = temperature(costs, self.max_kl, self.least_temperature)
        before, old = self._gaussian.distribution(), Gaussian(*self._gaussian.moments())
        self._gaussian.set_moments(*bounded_fit(old, z, sample_weights(costs, eta), self.max_kl))
        moved = kl_divergence(self._gaussian.distribution(), before).item()
        mean = float(costs[known].mean())
        return z, {"discrepancy": mean, "divergence": moved, "temperature": eta, "infeasible": infeasible}

    def _costs(self, trial: Trial, played: TensorDict) -> Array:
        """Mean discrepancy of each context over the starts, shape (m,), of what was played, size [m, k, t]."""
        _, infeasible = outcomes(cast(TensorDict, played.flatten(0, 1)))
        costs = self._by_start(trial, played).mean(1)
        return np.where(infeasible.reshape(len(played), -1).any(1), np.nan, costs)

    def _by_start(self, trial: Trial, played: TensorDict) -> Array:
        """Discrepancy of each context from each start, shape (m, k)."""
        pairs = zip(trial.real.unbind(0), played.unbind(1), strict=True)
        return np.stack([self._discrepancy(self._measured, real, each) for real, each in pairs], 1)

    def _look(self, experience: Experience, trial: Trial, drawn: Array) -> float:
        """Keep for pictures how the model at the mean and in some contexts moves; gives the mean's discrepancy."""
        mean = self._gaussian.moments()[0]
        mean = self._setting.space.clip(mean) if self._gaussian.clip else mean
        played = trial.simulated(experience, np.concatenate([mean[None], drawn]))
        worst = int(self._by_start(trial, played)[0].argmax())
        real, seen = (cast(TensorDict, each) for each in (trial.real[worst], played[:, worst]))
        self._compared = comparisons(list(self._measured), self._setting.seconds, real, seen)
        return float(self._costs(trial, played)[0])


def _require_gaussian(randomizer: Randomizer) -> GaussianRandomizer:
    if not isinstance(randomizer, GaussianRandomizer):
        raise ConfigError(
            f"distribution_learner=simopt moves a Gaussian, which {type(randomizer).__name__} is not. Take "
            "randomizer=gaussian or from_run."
        )
    return randomizer
