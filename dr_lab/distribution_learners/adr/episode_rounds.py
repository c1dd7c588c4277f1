"""Rounds in which slots play the proposals, a whole episode each."""

from collections.abc import Mapping
from functools import cached_property
from typing import Any, cast

from tensordict import TensorDict
from torch import Tensor

from dr_lab.collectors.experience import Experience
from dr_lab.distribution_learners.adr.rounds import ProposalRounds
from dr_lab.distribution_learners.adr.whole_episodes import EpisodeAssembler


class EpisodeRounds(ProposalRounds):
    """Rounds whose proposals are each answered by the first whole episode in it.

    Args: as `ProposalRounds`.
    """

    @cached_property
    def _episodes(self) -> EpisodeAssembler:
        """The episodes that slots are under way with."""
        return EpisodeAssembler(self._hidden)

    def _take(self, batch: TensorDict, experience: Experience) -> None:
        del experience
        for episode in self._episodes.take(batch):
            place = self._proposals.answer(episode.key)
            if place is not None:
                self._answers[place] = episode
        goes_on = ~cast(Tensor, batch["next", "done"])[:, -1, 0].numpy()
        self._proposals.run(cast(Tensor, batch["proposal"])[:, -1].numpy()[goes_on])

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return super().state_dict() | {"episodes": self._episodes.state_dict()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        super().load_state_dict(state)
        self._episodes.load_state_dict(state["episodes"])
