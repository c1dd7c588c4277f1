"""Meta-ADR: particles propose the tasks in which trajectories after an adaptation differ from those before it."""

from collections.abc import Callable, Mapping, Sequence
from typing import cast

from tensordict import TensorDict
from torch import Tensor

from dr_lab.collectors.experience import Experience
from dr_lab.collectors.first_episodes import first_episodes
from dr_lab.distribution_learners.adr.adr import ADR, Inherited
from dr_lab.distribution_learners.adr.discriminator import Discriminator
from dr_lab.distribution_learners.adr.whole_episodes import WholeEpisode, transitions
from dr_lab.distribution_learners.meta_adr.dealt_proposals import DealtProposals
from dr_lab.distribution_learners.svpg.svpg import SVPG
from dr_lab.errors import ConfigError
from dr_lab.randomizers.context_source import UNKEYED
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.trajectory import Array


class MetaADR(ADR):
    """Active domain randomisation of the tasks of a meta-learner, without episodes of its own.

    A round: SVPG's particles propose tasks z, which the meta-learner plays before and after it adapts to them. The
    reward of a proposal is

        r(z) = mean over the episodes after the adaptation of log f(s, a, s′) − log ½,

    where f is the probability that a transition is one after an adaptation, as it was before these episodes. Then f
    learns from both sides, and the particles from r. An infeasible task is rewarded as the lowest feasible one so far,
    at most 0, and f does not see it.

    Source: Mehta, thesis, 2020, equation 4.2.2 and algorithm 4, in which f judges whole trajectories; by transitions it
    is that of ADR.

    Args: as `ADR`, without `reference_load`.

    Raises:
        ConfigError: as `ADR`.
    """

    def __init__(
        self,
        randomizer: Randomizer,
        seed: int,
        svpg: Callable[[int, int], SVPG],
        discriminator: Callable[[int, int], Discriminator],
        context_shown: bool,
        inherits: Sequence[Inherited],
    ) -> None:
        super().__init__(randomizer, seed, svpg, discriminator, 1, context_shown, inherits)

    def update(self, batch: TensorDict, experience: Experience) -> Mapping[str, float]:
        """Take what was played before or after an adaptation; where a round ends, learn and give its figures."""
        if "updates_left" not in batch:
            raise ConfigError(
                "distribution_learner=meta_adr tells episodes before an adaptation from those after it, and the "
                "algorithm adapts to nothing. Take a meta-learner: algorithm=maml."
            )
        self._frames += batch.numel()
        before, after = (not cast(Tensor, batch[key])[0, 0] for key in ("updates", "updates_left"))
        if not before and not after:
            return {}
        for place, rows, infeasible in self._by_place(experience.executed(batch)):
            if before:
                self._references.append(rows)
            elif self._proposals.answer(place + self._proposals.first) is not None:
                self._answers[place] = WholeEpisode(place + self._proposals.first, rows, infeasible)
        return self._end_round() if self._proposals.answered else {}

    def _by_place(self, batch: TensorDict) -> list[tuple[int, Tensor, bool]]:
        """Of each proposal of this round that was played: its place, transitions, and whether it is infeasible."""
        keys = cast(Tensor, batch["proposal"])[:, 0]
        if (keys == UNKEYED).any():
            raise ConfigError("distribution_learner=meta_adr proposes tasks, but the algorithm plays others.")
        first, rows = first_episodes(batch), transitions(batch, self._hidden)
        infeasible = (cast(Tensor, batch["next", "infeasible"])[..., 0] & first).any(1)
        found = list[tuple[int, Tensor, bool]]()
        for key in sorted({*cast(list[int], keys.tolist())}):
            here, place = keys == key, key - self._proposals.first
            if 0 <= place < len(self._proposals.z):
                found.append((place, rows[here][first[here]], bool(infeasible[here].any())))
        return found

    def _opened(self, z: Array) -> DealtProposals:
        return DealtProposals(z)
