"""Distilled domain randomisation."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, cast

from tensordict import TensorDict
from torch import Tensor

from dr_lab.algorithms.algorithm import Interface
from dr_lab.algorithms.didor.distillation import Distillation
from dr_lab.algorithms.didor.turns import Turns
from dr_lab.algorithms.teachers.taught import Taught
from dr_lab.algorithms.teachers.teachers import Teachers
from dr_lab.bounds import Count, at_least, require_bounds
from dr_lab.collectors.collector import Policy
from dr_lab.errors import ConfigError
from dr_lab.networks.gaussian import Gaussian
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.seeding import derived_seed


class DiDoR(Taught):
    """Trains N teachers, each in one domain, and then distils them into one student, which is deployed.

    1. For `teacher_frames` control steps every teacher is trained by PPO in its own domain, all side by side.
    2. From then on the student acts, in the domains of all teachers. In the states that it visits it learns to do what
       the teacher of that domain would do.

    Every iteration collects a whole episode in each slot.

    Source: Brosseit et al., Distilled Domain Randomization, 2021, algorithm 1.

    Args:
        interface: what the policies are connected to.
        seed: of everything that is random.
        teachers: makes the teachers, from interface and seed.
        student: makes the student, from observation width, bounds and seed.
        distillation: makes what the student learns by, from the student and a seed.
        teacher_frames: control steps that the teachers are trained for, all together.
        frames: control steps of the run.
        batch_frames: control steps that are collected at once until every slot has ended an episode.

    Raises:
        ConfigError: a number is out of its range, or nothing is left for the student.
    """

    def __init__(
        self,
        interface: Interface,
        seed: int,
        teachers: Callable[[Interface, int], Teachers],
        student: Callable[..., GaussianActor],
        distillation: Callable[[GaussianActor, int], Distillation],
        teacher_frames: Annotated[int, at_least(0)],
        frames: int,
        batch_frames: Count,
    ) -> None:
        self.teacher_frames, self.batch_frames = teacher_frames, batch_frames
        require_bounds(self, "algorithm", DiDoR)
        if teacher_frames >= frames:
            raise ConfigError(
                f"algorithm.teacher_frames is {teacher_frames} of {frames} control steps (frames), which leaves "
                "nothing for the student. Lower it, or raise frames."
            )
        super().__init__(interface, seed, teachers)
        bounds = (interface.low, interface.high)
        self.student = student(interface.observation, *bounds, derived_seed(seed, "student")).to(interface.device)
        self.distillation = distillation(self.student, seed)
        self._turns = Turns(self.teachers.acting, self.student)
        self._count(0)

    @property
    def policies(self) -> Mapping[str, Policy]:
        """The student, which explores."""
        return {"policy": self.student}

    @property
    def collecting(self) -> Policy:
        """The teachers, or the student when its turn has come."""
        return self._turns

    @property
    def deployed(self) -> Policy:
        """The student's most likely action."""
        return self.student.mean

    def update(self, batch: TensorDict) -> Mapping[str, float]:
        """Let the teachers learn, or the student, whichever acted."""
        figures = self._distil(batch) if self._turns.student_acts else self.teachers.update(batch)
        self._count(self.frames + batch.numel())
        return figures

    def _count(self, frames: int) -> None:
        """Note how many control steps have been played, and whose turn it is."""
        self.frames = frames
        self._turns.student_acts.fill_(frames >= self.teacher_frames)

    def _distil(self, batch: TensorDict) -> Mapping[str, float]:
        feasible = ~cast(Tensor, batch["next", "infeasible"]).squeeze(-1)
        observation = cast(Tensor, batch["observation"])
        taught = self.teachers.acting.distribution(observation)
        return self.distillation.learn(observation[feasible], Gaussian(taught.mean[feasible], taught.log_std[feasible]))

    def explore_anew(self, seed: int) -> None:
        """As `Taught`, and distil from states in another order."""
        super().explore_anew(seed)
        self.distillation.explore_anew(seed)

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {
            **super().state_dict(),
            "student": self.student.state_dict(),
            "distillation": self.distillation.state_dict(),
            "frames": self.frames,
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        super().load_state_dict(state)
        self.student.load_state_dict(state["student"])
        self.distillation.load_state_dict(state["distillation"])
        self._count(state["frames"])
