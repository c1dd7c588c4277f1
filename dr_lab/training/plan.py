"""A training run put together: environment, policy, distribution and loop."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from dr_lab.algorithms.algorithm import Algorithm, Interface
from dr_lab.bounds import Count, Natural, above, at_most, require_bounds
from dr_lab.collectors.boundary import boundary_to
from dr_lab.collectors.collector import Collector
from dr_lab.collectors.experience import Experience
from dr_lab.distribution_learners.distribution_learner import DistributionLearner
from dr_lab.envs.environment import Environment
from dr_lab.errors import ConfigError
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.seeding import derived_seed
from dr_lab.training.device import require_device
from dr_lab.training.trainer import Stateful, Trainer

CHECKPOINT = "checkpoint.pt"  # the last state, from which a run goes on
POLICY = "policy.pt"  # the policy that was chosen to be deployed, once a run has ended


@dataclass(frozen=True)
class Plan:
    """What is trained, and on what; the verbs `train` and `evaluate` put it together from the same configuration.

    Attributes:
        env: machine and task.
        algorithm: makes the algorithm, from what the policy is connected to and a seed.
        randomizer: makes p(z) over the machine's context.
        distribution_learner: makes what shapes it, from p(z) and a seed.
        collector: makes the collector, from an environment, a policy and the control steps of a slot in a batch.
        episodes: slots that run side by side.
        rollout_episodes: slots of the episodes that a distribution learner plays.
        frames: control steps of training in all.
        checkpoint_every: control steps between two checkpoints.
        seed: of every random draw.
        threads: C threads of the physics; None takes every core.
        final_share: share of the iterations whose episodes make up the final return, the last ones.
        device: on which policies learn, as torch calls it; they act on the CPU, where the physics is.

    Raises:
        ConfigError: a number is out of its range, or there is no such device.
    """

    env: Environment
    algorithm: Callable[..., Algorithm]
    randomizer: Callable[[ContextSpace], Randomizer]
    distribution_learner: Callable[..., DistributionLearner]
    collector: Callable[..., Collector]
    episodes: Count
    rollout_episodes: Count
    frames: Count
    checkpoint_every: Count
    seed: Natural
    threads: int | None
    final_share: Annotated[float, above(0.0), at_most(1.0)] = 1.0
    device: str = "cpu"

    def __post_init__(self) -> None:
        require_bounds(self, "")
        require_device(self.device)

    def assemble(
        self, checkpoint: Path | None, shape: Callable[[DistributionLearner], None] = lambda _: None
    ) -> "Training":
        """Build everything.

        Args:
            checkpoint: file that a later run continues from; None keeps none.
            shape: gives the distribution the state from which the first episodes are drawn; it stays by default.

        Raises:
            ConfigError: a batch does not hold one control step of each slot.
        """
        randomizer = self.randomizer(self.env.space)
        learner = self.distribution_learner(randomizer, self.seed)
        shape(learner)
        env = self.env.make(learner.source, self.episodes, self.seed, self.threads, staggered=True)
        slots = env.episodes
        device = require_device(self.device)
        algorithm = self.algorithm(Interface(slots.observation.shape[1], slots.low, slots.high, device), self.seed)
        steps = algorithm.batch_frames // self.episodes
        if steps < 1:
            raise ConfigError(
                f"algorithm.batch_frames is {algorithm.batch_frames}, less than one control step for each of "
                f"{self.episodes} episodes. Raise it, or lower episodes."
            )
        between = boundary_to(device)
        learnt = (algorithm.policies["policy"], algorithm.collecting, algorithm.deployed)
        policy, collecting, deployed = between.acting(learnt)
        played = self.env.make(None, self.rollout_episodes, self._seed_of_rollouts(), self.threads).episodes
        collector = self.collector(env, collecting, steps)
        experience = Experience(collector, policy, played, learner.source, deployed, between)
        more: dict[str, Stateful] = {}
        trainer = Trainer(experience, algorithm, learner, checkpoint, self.checkpoint_every, more, self.env.time_limit)
        return Training(trainer, algorithm, experience, randomizer, learner, more)

    def _seed_of_rollouts(self) -> int:
        """Another seed than that of the slots, whose starts would otherwise be the same."""
        return derived_seed(self.seed, "rollouts")


@dataclass(frozen=True)
class Training:
    """A training run that can be started.

    Attributes:
        trainer: the loop; to be closed at the end.
        algorithm: what learns the policy.
        experience: what it learns from.
        randomizer: p(z).
        learner: what shapes it.
        more: what else the checkpoint holds, by name; may be added to before the loop starts.
    """

    trainer: Trainer
    algorithm: Algorithm
    experience: Experience
    randomizer: Randomizer
    learner: DistributionLearner
    more: dict[str, Stateful]
