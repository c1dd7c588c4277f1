"""Training that begins with what an earlier run learnt."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from dr_lab.distribution_learners.distribution_learner import DistributionLearner
from dr_lab.errors import DataError
from dr_lab.run_command import command_of
from dr_lab.training.finished_run import difference, require_run
from dr_lab.training.plan import Plan, Training
from dr_lab.training.run_state import RunState


@dataclass(frozen=True)
class Beginning:
    """What a new run takes over from a finished one; all else, random numbers and counters included, is its own.

    The policy is the one that the finished run chose to be deployed, with its normaliser. The rest of what was
    learnt (value networks, optimisers, scale of rewards) is taken over as it was last.

    Attributes:
        run: folder of the finished run, of the same algorithm on the same observations and actions; None takes nothing
            over.
        distribution: whether p(z), and what shapes it, is taken over; randomizer and learner are to be the same.
        policy: whether the policy, and what was learnt with it, is.
    """

    run: str | None
    distribution: bool
    policy: bool = True

    def assemble(self, plan: Plan, checkpoint: Path | None) -> Training:
        """Build a training in the state that the finished run left.

        The distribution is taken over before the first episodes begin, so that these are of it, too.

        Args:
            plan: the new run.
            checkpoint: file that a later run continues from; None keeps none.

        Raises:
            DataError: there is no such run, or its networks or its distribution are others.
        """
        if self.run is None:
            return plan.assemble(checkpoint)
        remedy = "Give init=FOLDER of a run of dr-lab train, or leave init out."
        folder = require_run(Path(self.run).expanduser(), f"init={self.run}", remedy)
        finished = RunState.load(folder)

        def shape(learner: DistributionLearner) -> None:
            if self.distribution:
                with self._fitting(folder):
                    learner.inherit(finished.last["learner"])

        training = plan.assemble(checkpoint, shape)
        if self.policy:
            with self._fitting(folder):
                finished.train_on(training.algorithm, plan.seed)
        return training

    @contextmanager
    def _fitting(self, folder: Path) -> Iterator[None]:
        try:
            yield
        except (KeyError, RuntimeError, TypeError, ValueError) as error:
            made = command_of(folder)
            raise DataError(
                f"init={self.run} is a run with another algorithm, other networks or another distribution: "
                f"{difference(error)} {f'It was made by {made}. ' if made else ''}Give algorithm, env and, with "
                f"init_distribution=true, randomizer and distribution_learner as in {folder / 'config.yaml'}."
            ) from error
