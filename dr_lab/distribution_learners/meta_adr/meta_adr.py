"""Meta-ADR: particles propose the tasks in which trajectories after an adaptation differ from those before it."""

from typing import cast

from tensordict import TensorDict
from torch import Tensor

from dr_lab.collectors.experience import Experience
from dr_lab.collectors.first_episodes import first_episodes
from dr_lab.distribution_learners.adr.rounds import ProposalRounds
from dr_lab.distribution_learners.adr.whole_episodes import WholeEpisode, transitions
from dr_lab.distribution_learners.meta_adr.dealt_proposals import DealtProposals
from dr_lab.errors import ConfigError
from dr_lab.trajectory import Array


class MetaADR(ProposalRounds):
    """Active domain randomisation of the tasks of a meta-learner, without episodes of its own.

    A round, see `ProposalRounds`: the meta-learner plays what the particles propose before and after it adapts to it.
    The reward of a proposal is

        r(z) = mean over the episodes after the adaptation of log f(s, a, s′) − log ½,

    where f, the discriminator, is the probability that a transition is one after an adaptation. Those before are its
    reference. A task in which an episode of either is infeasible is infeasible.

    Source: Mehta, thesis, 2020, equation 4.2.2 and algorithm 4, in which f judges whole trajectories; by transitions it
    is that of ADR.

    Args: as `ProposalRounds`.

    Raises:
        ConfigError: as `ProposalRounds`.
    """

    OPTION = "meta_adr"

    def _take(self, batch: TensorDict, experience: Experience) -> None:
        del experience
        if "updates_left" not in batch:
            raise ConfigError(
                "distribution_learner=meta_adr tells episodes before an adaptation from those after it, and the "
                "algorithm adapts to nothing. Take a meta-learner: algorithm=maml."
            )
        before, after = (not cast(Tensor, batch[key])[0, 0] for key in ("updates", "updates_left"))
        for place, rows, infeasible in self._by_place(batch) if before or after else ():
            key = place + self._proposals.first
            if before and not infeasible:
                self._references.append(rows)
            elif before or self._proposals.answer(key) is not None:
                self._answers.setdefault(place, WholeEpisode(key, rows, infeasible))  # once infeasible, it stays so

    def _by_place(self, batch: TensorDict) -> list[tuple[int, Tensor, bool]]:
        """Of each proposal of this round that was played: its place, transitions, and whether it is infeasible."""
        keys, first = cast(Tensor, batch["proposal"])[:, 0], first_episodes(batch)
        rows = transitions(batch, self._hidden)
        infeasible = (cast(Tensor, batch["next", "infeasible"])[..., 0] & first).any(1)
        found = list[tuple[int, Tensor, bool]]()
        for key in sorted({*cast(list[int], keys.tolist())}):
            here, place = keys == key, key - self._proposals.first
            if 0 <= place < len(self._proposals.z):
                found.append((place, rows[here][first[here]], bool(infeasible[here].any())))
        return found

    def _opened(self, z: Array) -> DealtProposals:
        return DealtProposals(z)
