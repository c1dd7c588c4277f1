"""The contract of an algorithm whose policy is made to be adapted."""

from abc import abstractmethod

from dr_lab.algorithms.algorithm import Algorithm
from dr_lab.collectors.experience import Experience
from dr_lab.networks.policy_stack import PolicyStack
from dr_lab.randomizers.context_source import Proposals


class MetaAlgorithm(Algorithm):
    """Knows how its policy is adapted to a context, for some contexts at once.

    Attributes:
        tasks: T, contexts that it adapts to at once.
        adapted_policies: one policy a context, as far as it is adapted.
    """

    tasks: int
    adapted_policies: PolicyStack

    @property
    def judged_by_return(self) -> bool:
        """No: what a policy returns before it is adapted says nothing of what it is made for."""
        return False

    @abstractmethod
    def begin_adapting(self) -> None:
        """Let every adapted policy be the policy itself, which stays as it is whatever becomes of them."""

    @abstractmethod
    def adapt_once(self, experience: Experience, tasks: Proposals, done: int) -> object:
        """Play whole episodes in some tasks with the adapted policies, and update each of these by its own.

        Args:
            experience: collects with `collecting`, which is `adapted_policies`.
            tasks: T of them.
            done: updates that the policies have had.

        Returns:
            What was played before the update.
        """
