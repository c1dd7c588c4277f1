"""ADR: particles propose the contexts in which a policy's transitions differ from those of the reference."""

from collections.abc import Callable, Sequence
from typing import cast

import numpy as np
from tensordict import TensorDict
from torch import Tensor

from dr_lab.bounds import Count, require_bounds
from dr_lab.collectors.experience import Experience
from dr_lab.distribution_learners.adr.discriminator import Discriminator
from dr_lab.distribution_learners.adr.episode_rounds import EpisodeRounds
from dr_lab.distribution_learners.adr.rounds import Inherited
from dr_lab.distribution_learners.adr.whole_episodes import transitions
from dr_lab.distribution_learners.svpg.svpg import SVPG
from dr_lab.errors import ConfigError
from dr_lab.randomizers.randomizer import Randomizer


class ADR(EpisodeRounds):
    """Active domain randomisation.

    A round, see `ProposalRounds`: slots play what the particles propose, and as many episodes are played by the same
    exploring policy in the reference, the nominal context, which nothing trains on. The reward of a proposal is

        r(z) = mean over its episode of log D(s, a, s′) − log ½.

    References are played as soon as `reference_load` proposals are answered, so that the policy of either side is of
    about the same age: else D could tell how far it had come in between. One that diverges is left out, and played
    again with the next.

    Source: Mehta, thesis, 2020, chapter 2, algorithm 2 and appendix A.6. It gives the mean of D, its code
    log(mean of D); the mean of log D is the log-likelihood of the episode's transitions per step. That code plays the
    reference without the noise of exploration, which D can learn in place of the dynamics, and lets D see no more than
    the first transitions of an episode.

    Limits: an algorithm that gives its slots contexts of its own, as EPOpt does, answers no proposal.

    Args: as `ProposalRounds`, and
        reference_load: episodes of the reference that are played side by side.

    Raises:
        ConfigError: as `ProposalRounds`.
    """

    OPTION = "adr"

    def __init__(
        self,
        randomizer: Randomizer,
        seed: int,
        svpg: Callable[[int, int], SVPG],
        discriminator: Callable[[int, int], Discriminator],
        context_shown: bool,
        inherits: Sequence[Inherited],
        reference_load: Count,
    ) -> None:
        super().__init__(randomizer, seed, svpg, discriminator, context_shown, inherits)
        self.reference_load = reference_load
        require_bounds(self, "distribution_learner", ADR)

    def _take(self, batch: TensorDict, experience: Experience) -> None:
        super()._take(batch, experience)
        lacking = len(self._answers) - len(self._references)
        if lacking >= self.reference_load or (lacking and self._proposals.answered):
            self._play_references(experience, lacking)

    def _play_references(self, experience: Experience, count: int) -> None:
        nominal = np.tile(self.randomizer.space.nominal, (count, 1))
        played = experience.executed(experience.play(experience.policy, nominal))
        feasible = ~cast(Tensor, played["next", "infeasible"]).flatten(1).any(1)
        if not feasible.any() and not self._references:
            raise ConfigError(
                "The nominal context, which is the reference of distribution_learner=adr, is infeasible. Choose "
                "nominal values in which the machine can be simulated."
            )
        known = cast(TensorDict, played[feasible])
        lengths = cast(Tensor, known["mask"]).sum(1).tolist()
        rows = transitions(known, self._hidden)
        self._references += [each[:length].clone() for each, length in zip(rows, lengths, strict=True)]
