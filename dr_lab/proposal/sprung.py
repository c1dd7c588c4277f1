"""What commands do beside a spring that the model lacks, such as the pull of a cable.

Where a joint's forces stay unexplained, a command's sign and gain are judged wrongly: it holds the spring as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from dr_lab.proposal.search import Found
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.trial import Outcome, Trial


@dataclass(frozen=True)
class Sprung:
    """An outcome whose commands act beside springs where that explains the motion.

    Attributes:
        outcome: by which commands are chosen.
        dofs: degrees of freedom whose motion a spring explains, and nothing else did.
    """

    outcome: Outcome
    dofs: tuple[int, ...]

    def doubts(self, joints: Sequence[str], before: Outcome) -> list[str]:
        """What is said of each joint that a spring seems to pull.

        Args:
            joints: by degree of freedom.
            before: without springs.
        """
        return [
            f"A spring at {joints[dof]} that the model lacks, a cable's perhaps, would leave "
            f"{self.outcome.left[dof]:.1%} of its forces in place of {before.left[dof]:.0%}: its command is read "
            "beside one. close tries it."
            for dof in self.dofs
        ]


def beside_springs(trial: Trial, found: Found, settings: ProposalSettings) -> Sprung:
    """What each series gives, beside a spring at joints of which only that leaves as little as `settings.well`."""
    before = found.outcome
    if float(before.left.max()) <= settings.well or any(trial.servos):  # a servo is a spring itself
        return Sprung(before, ())
    after = replace(trial, sprung=True)(found.readings)
    dofs = tuple(map(int, np.flatnonzero((before.left > settings.well) & (after.left <= settings.well))))
    idle, given = before.idle.copy(), [*before.given]
    for dof in dofs:
        idle[dof], given[dof] = after.idle[dof], after.given[dof]
    return Sprung(replace(before, idle=idle, given=tuple(given)), dofs)
