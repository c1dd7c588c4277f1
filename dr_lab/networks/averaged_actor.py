"""A policy that is the mean of what another one was."""

import copy

import torch
from torch import Tensor, nn

from dr_lab.networks.deterministic_actor import DeterministicActor
from dr_lab.networks.flat import FlatParameters


class AveragedActor(nn.Module):
    """Acts without noise under the mean of an actor's parameters: θ̄ ← θ̄ + (θ − θ̄)/min(k, n) at its k-th step.

    What a single step does to the policy, good or bad, is averaged out. Of the first n steps it is the plain mean, then
    one that forgets with a half-life of about 0.7 n steps; for n = 1 it is the actor itself.

    Source: Polyak and Juditsky 1992, for the mean; with forgetting as Tarvainen and Valpola 2017.

    Args:
        actor: whose parameters are averaged; the normaliser is its own.
        steps: n.

    Attributes:
        vector: θ̄, shape (p,).
        taken: k so far, of no dimension.
    """

    taken: Tensor

    def __init__(self, actor: DeterministicActor, steps: int) -> None:
        super().__init__()
        self.actor = copy.deepcopy(actor)
        self.actor.normaliser = actor.normaliser
        self.vector = FlatParameters(self.actor.body.parameters()).vector
        self._steps = steps
        self.register_buffer("taken", torch.zeros((), dtype=torch.int64))

    def take(self, vector: Tensor) -> None:
        """Take the actor's parameters θ (p,) after a step into the mean."""
        self.taken += 1
        self.vector.lerp_(vector, 1.0 / min(int(self.taken), self._steps))

    def forward(self, observation: Tensor) -> Tensor:
        """Actions (…, nu) for observations (…, o)."""
        return self.actor.mean(observation)
