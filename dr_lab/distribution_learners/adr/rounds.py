"""What learners with particles share: rounds of proposals that are played, rewarded by a discriminator, learnt from."""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, Literal, cast

import torch
from tensordict import TensorDict
from torch import Tensor

from dr_lab.collectors.experience import Experience
from dr_lab.distribution_learners.adr.discriminator import Discriminator
from dr_lab.distribution_learners.adr.proposals import OpenProposals
from dr_lab.distribution_learners.adr.whole_episodes import WholeEpisode
from dr_lab.distribution_learners.distribution_learner import DistributionLearner
from dr_lab.distribution_learners.svpg.svpg import SVPG
from dr_lab.errors import ConfigError
from dr_lab.randomizers.context_source import UNKEYED
from dr_lab.randomizers.empirical import EmpiricalRandomizer
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.seeding import derived_seed
from dr_lab.trajectory import Array

Inherited = Literal["particles", "discriminator"]


class ProposalRounds(DistributionLearner):
    """Rounds of proposals.

    SVPG's particles propose contexts z, which are played. When all are answered, the reward of a proposal follows from
    log D − log ½ of its transitions, D as it was before them. Then D learns to tell them from those of a reference, and
    the particles learn from the rewards. An infeasible context is rewarded as the lowest feasible one so far, at most
    0, and D does not see it. Transitions show what the machine did: actions are cut off at its bounds.

    Args:
        randomizer: is told what was proposed; its box is what the particles' unit cube stands for.
        seed: of particles and discriminator.
        svpg: makes the particles, from the number of parameters and a seed.
        discriminator: makes D, from the width of a transition and a seed.
        context_shown: whether observations end with the context, which D must not see.
        inherits: what is taken over where training begins with the distribution of another run.

    Raises:
        ConfigError: contexts cannot be noted in the randomizer, the context has no parameters, or a number is out of
            its range.
    """

    OPTION: ClassVar[str]  # by which it is chosen, for messages

    randomizer: EmpiricalRandomizer

    def __init__(
        self,
        randomizer: Randomizer,
        seed: int,
        svpg: Callable[[int, int], SVPG],
        discriminator: Callable[[int, int], Discriminator],
        context_shown: bool,
        inherits: Sequence[Inherited],
    ) -> None:
        super().__init__(_require_empirical(randomizer, self.OPTION))
        self.inherits = tuple(inherits)
        size = len(randomizer.space.names)
        self._svpg = svpg(size, derived_seed(seed, "svpg"))
        self._make, self._seed = discriminator, derived_seed(seed, "discriminator")
        self._discriminator: Discriminator | None = None  # until the width of a transition is known
        self._hidden = size if context_shown else 0
        self._proposals = self._opened(self._contexts())
        self._answers: dict[int, WholeEpisode] = {}  # by the place of the proposal
        self._references: list[Tensor] = []  # transitions that were met in this round, part by part
        self._frames, self._lowest = 0, 0.0

    @property
    def source(self) -> OpenProposals:
        """The proposals."""
        return self._proposals

    @property
    def learns(self) -> bool:
        """Always."""
        return True

    def update(self, batch: TensorDict, experience: Experience) -> Mapping[str, float]:
        """Take the answers of a batch; where they end a round, learn from it and give its figures.

        Raises:
            ConfigError: the algorithm plays contexts of its own.
        """
        if (cast(Tensor, batch["proposal"])[:, -1] == UNKEYED).any():
            raise ConfigError(
                f"distribution_learner={self.OPTION} proposes contexts, but the algorithm gives its episodes others, "
                "so that no proposal is ever answered. Take an algorithm that does not."
            )
        self._frames += batch.numel()
        self._take(experience.executed(batch), experience)
        return self._end_round() if self._proposals.answered else {}

    @abstractmethod
    def _take(self, batch: TensorDict, experience: Experience) -> None:
        """Note what a batch, with actions as they were executed, says of proposals and of the reference."""

    def _reference(self) -> Tensor:
        """Transitions of the reference in this round, shape (k, f)."""
        return torch.cat(self._references)

    def _worth(self, log_ratio: Tensor) -> float:
        """Reward of a proposal whose transitions have these log D − log ½, shape (t,): their mean."""
        return float(log_ratio.mean())

    def _opened(self, z: Array) -> OpenProposals:
        """What gives the proposals out."""
        return OpenProposals(z)

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        answers = {
            place: {"key": each.key, "transitions": each.transitions, "infeasible": each.infeasible}
            for place, each in self._answers.items()
        }
        return super().state_dict() | {
            "svpg": self._svpg.state_dict(),
            "discriminator": None if self._discriminator is None else self._discriminator.state_dict(),
            "proposals": self._proposals.state_dict(),
            "answers": answers,
            "references": list(self._references),
            "frames": self._frames,
            "lowest": self._lowest,
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        super().load_state_dict(state)
        self._svpg.load_state_dict(state["svpg"])
        found = state["discriminator"]
        if found is not None:
            self._made(found["size"]).load_state_dict(found)
        self._proposals.load_state_dict(state["proposals"])
        self._answers = {place: WholeEpisode(**each) for place, each in state["answers"].items()}
        self._references = list(state["references"])
        self._frames, self._lowest = state["frames"], state["lowest"]

    def inherit(self, state: Mapping[str, Any]) -> None:
        """Begin with the particles, the discriminator or both of another run; walks and rounds are new."""
        if "particles" in self.inherits:
            self._svpg.inherit(state["svpg"])
            self._proposals.renew(self._contexts())
        if "discriminator" in self.inherits and state["discriminator"] is not None:
            self._made(state["discriminator"]["size"]).inherit(state["discriminator"])

    def _contexts(self) -> Array:
        """What the particles propose next, shape (N·k, n)."""
        low, high = self.randomizer.low.numpy(), self.randomizer.high.numpy()
        unit = self._svpg.propose().flatten(0, 1).double().numpy()
        return low + unit * (high - low)

    def _made(self, size: int) -> Discriminator:
        if self._discriminator is None:
            self._discriminator = self._make(size, self._seed)
        return self._discriminator

    def _end_round(self) -> Mapping[str, float]:
        """Reward the proposals, let D and the particles learn, and propose anew."""
        answers = [self._answers[place] for place in range(len(self._proposals.z))]
        feasible = [each.transitions for each in answers if not each.infeasible]
        figures = {"proposals_infeasible": 1.0 - len(feasible) / len(answers)}
        rewards = torch.full((len(answers),), self._lowest)
        if feasible:
            randomised, reference = torch.cat(feasible), self._reference()
            discriminator = self._made(randomised.shape[1])
            discriminator.adapt(torch.cat([randomised, reference]))
            rewards = self._rewards(discriminator, answers)
            figures["discriminator_accuracy"] = discriminator.accuracy(randomised, reference)
            figures["discriminator_loss"] = discriminator.learn(randomised, reference)
        figures["proposal_reward"] = float(rewards.mean())
        figures |= self._svpg.learn(rewards.reshape(self._svpg.count, self._svpg.proposals))
        self.randomizer.note(self._proposals.z, self._frames)
        self._proposals.renew(self._contexts())
        self._answers, self._references = {}, []
        return figures

    def _rewards(self, discriminator: Discriminator, answers: Sequence[WholeEpisode]) -> Tensor:
        """Reward of each proposal, shape (k,)."""
        found = [
            None if each.infeasible else self._worth(discriminator.log_ratio(each.transitions)) for each in answers
        ]
        self._lowest = min(self._lowest, *(each for each in found if each is not None))
        return torch.tensor([self._lowest if each is None else each for each in found])


def _require_empirical(randomizer: Randomizer, option: str) -> EmpiricalRandomizer:
    if not isinstance(randomizer, EmpiricalRandomizer):
        raise ConfigError(
            f"distribution_learner={option} notes what it proposes, which {type(randomizer).__name__} cannot. Take "
            "randomizer=empirical, whose ranges are those of the proposals."
        )
    if not randomizer.space.names:
        raise ConfigError(
            f"distribution_learner={option} has nothing to propose: the machine varies no parameter. Choose some, e.g. "
            "env/context=hopper/torso_mass."
        )
    return randomizer
