"""ADR+: particles propose the contexts in which a policy's transitions look like an expert's."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from tensordict import TensorDict
from torch import Tensor

from dr_lab.collectors.experience import Experience
from dr_lab.distribution_learners.adr.discriminator import Discriminator
from dr_lab.distribution_learners.adr.episode_rounds import EpisodeRounds
from dr_lab.distribution_learners.adr.rounds import Inherited
from dr_lab.distribution_learners.adr_plus.prior_particles import PriorParticles
from dr_lab.distribution_learners.svpg.svpg import SVPG
from dr_lab.errors import ConfigError
from dr_lab.experts.expert import Expert
from dr_lab.randomizers.randomizer import Randomizer


class ADRPlus(EpisodeRounds):
    """Active domain randomisation towards an expert's trajectories, with a finished run of ADR as the prior.

    A round, see `ProposalRounds`, has a reference that is not played: all that the expert did, perhaps on the real
    machine. The reward of a proposal is the negative of ADR's, mean log ½ − log D(s, a, s′), so that particles seek the
    contexts whose transitions cannot be told from the expert's. Each pays for walking otherwise than its prior does,
    see `PriorParticles`. A policy is trained on what they propose.

    Source: Mehta, thesis, 2020, §2.3.2 and algorithm 3.

    Limits: D sees an expert's own way of acting beside the dynamics; where the policy acts in another way everywhere,
    all proposals are told apart alike, and rewards say little. As for `ADR`, the algorithm must not give its slots
    contexts of its own.

    Args: as `ProposalRounds`, `inherits` holding the particles, and
        expert: whose trajectories are the reference.

    Raises:
        ConfigError: as `ProposalRounds`; or the particles know no prior.
    """

    OPTION = "adr_plus"

    def __init__(
        self,
        randomizer: Randomizer,
        seed: int,
        svpg: Callable[[int, int], SVPG],
        discriminator: Callable[[int, int], Discriminator],
        context_shown: bool,
        inherits: Sequence[Inherited],
        expert: Expert,
    ) -> None:
        super().__init__(randomizer, seed, svpg, discriminator, context_shown, inherits)
        self._expert, self._known = expert, None

    def update(self, batch: TensorDict, experience: Experience) -> Mapping[str, float]:
        """As `ProposalRounds`; the prior is to be known by then."""
        _require_prior(self._svpg)
        return super().update(batch, experience)

    def inherit(self, state: Mapping[str, Any]) -> None:
        """Begin with the particles of a run of ADR, which are the prior from then on."""
        super().inherit(state)
        _require_prior(self._svpg)

    def _worth(self, log_ratio: Tensor) -> float:
        return -super()._worth(log_ratio)

    def _reference(self) -> Tensor:
        """All transitions of the expert; read once."""
        if self._known is None:
            found, size = self._expert.demonstrations(), self._answers[0].transitions.shape[1]
            # Trajectories on the task with the context shown end with it, which D must not see.
            sides = [found.transitions(hidden) for hidden in (0, self._hidden)]
            fitting = [side for side in sides if side.shape[1] == size]
            if not fitting:
                raise ConfigError(
                    f"The expert's transitions have {sides[0].shape[1]} numbers, those of the policy that is trained "
                    f"{size}: observations before and after, and the action. Give trajectories of the same env."
                )
            self._known = fitting[0]
        return self._known


def _require_prior(svpg: SVPG) -> None:
    particles = svpg.particles
    if not isinstance(particles, PriorParticles) or particles.prior is None:
        raise ConfigError(
            "distribution_learner=adr_plus keeps its particles near those of a finished run of ADR, and knows none. "
            "Give one: init=FOLDER init_distribution=true (with init_policy=false for a new policy), and leave "
            "particles in distribution_learner.inherits."
        )
