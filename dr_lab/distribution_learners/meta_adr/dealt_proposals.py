"""Proposals that are dealt out in turn, so that one meta-batch answers as many as it has tasks."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dr_lab.distribution_learners.adr.proposals import OpenProposals
from dr_lab.randomizers.context_source import Proposals


class DealtProposals(OpenProposals):
    """Those of a round that no task has answered, in their order and over again; all of the round once none is left."""

    def propose(self, rngs: Sequence[np.random.Generator], slots: NDArray[np.intp]) -> Proposals:
        """One of the proposals a stream; nothing is random."""
        del slots
        waiting = np.flatnonzero(~self._answered)
        picked = np.resize(waiting if len(waiting) else np.arange(len(self.z)), len(rngs))
        return Proposals(self.z[picked], self.first + picked)
