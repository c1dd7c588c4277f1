"""Exploration before anything is learnt."""

import torch
from torch import Tensor, nn

from dr_lab.networks.deterministic_actor import DeterministicActor


class UniformStart(nn.Module):
    """Acts at random, uniformly within the bounds, until the actor is to be followed.

    An untrained actor does about the same everywhere, and its noise leaves most actions untried.

    Args:
        actor: what is followed, with its exploration, afterwards.

    Attributes:
        follows: whether the actor is followed, of one element.
    """

    follows: Tensor

    def __init__(self, actor: DeterministicActor) -> None:
        super().__init__()
        self.actor = actor
        self.register_buffer("follows", torch.zeros(1, dtype=torch.bool))

    @property
    def generator(self) -> torch.Generator:
        """The actor's random numbers, which these actions are drawn from too."""
        return self.actor.generator

    def reseed(self, seed: int) -> None:
        """Draw actions, uniform ones and the actor's, by the random numbers of this seed from here on."""
        self.actor.reseed(seed)

    @torch.no_grad()
    def forward(self, observation: Tensor) -> Tensor:
        """An exploring action (n, nu) for observations (n, o), within the bounds."""
        if self.follows:
            return self.actor(observation)
        centre, reach = self.actor.centre, self.actor.reach
        unit = torch.empty(len(observation), len(centre)).uniform_(-1.0, 1.0, generator=self.generator)
        return centre + reach * unit
