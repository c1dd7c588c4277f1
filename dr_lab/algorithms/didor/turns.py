"""Who acts: the teachers while they are trained, then the student."""

import torch
from torch import Tensor, nn

from dr_lab.collectors.collector import Policy
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.policy_stack import GaussianPolicyStack


class Turns(nn.Module):
    """Policies by slot, of which there are two sets that take turns.

    Args:
        teachers: N policies, each of which acts for its own slots.
        student: the policy that acts for all slots, those of every teacher, once it is its turn.

    Attributes:
        students: the student, N times.
        student_acts: whether it is the student's turn, of no dimension.
    """

    student_acts: Tensor

    def __init__(self, teachers: GaussianPolicyStack, student: GaussianActor) -> None:
        super().__init__()
        self.teachers = teachers
        self.students = GaussianPolicyStack([student] * len(teachers.policies))
        self.register_buffer("student_acts", torch.zeros((), dtype=torch.bool), persistent=False)

    @property
    def now(self) -> GaussianPolicyStack:
        """Those that act."""
        return self.students if self.student_acts else self.teachers

    @property
    def generator(self) -> torch.Generator:
        """Random numbers by which a collector seeds its workers."""
        return self.now.generator

    def forward(self, observation: Tensor) -> Tensor:
        """An action (n, nu) drawn for observations (n, o)."""
        return self.now(observation)

    def log_prob(self, observation: Tensor, action: Tensor) -> Tensor:
        """Log-density of actions (n, …, nu) at observations (n, …, o), shape (n, …)."""
        return self.now.log_prob(observation, action)

    def refresh(self) -> None:
        """Act as the policies are now."""
        self.now.refresh()

    def policy_of_slot(self, slots: int) -> Tensor:
        """Number of the teacher to whom each slot belongs, int64, shape (slots,)."""
        return self.now.policy_of_slot(slots)

    def of_worker(self, worker: int, workers: int) -> Policy:
        """The policies of the slots that a worker plays, where each plays an equal share of all."""
        return self.now.of_worker(worker, workers)

    def reseed(self, seed: int) -> None:
        """Draw actions by the random numbers of this seed from here on."""
        self.now.reseed(seed)
