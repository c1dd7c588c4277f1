"""SVPG: particles that propose points of the unit cube, and learn where they are rewarded."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import torch
from torch import Tensor

from dr_lab.bounds import Count, Positive, require_bounds
from dr_lab.distribution_learners.svpg.particles import Particles
from dr_lab.distribution_learners.svpg.stein import ascent_direction
from dr_lab.distribution_learners.svpg.walk import Walk, WalkStep


class SVPG:
    """Stein variational policy gradient with N actor-critics whose walks through [0, 1]ⁿ are the proposals.

    A round is `propose`, then `learn` from a reward for each proposal. Actors climb along Adam of φ, see
    `stein.ascent_direction`; critics descend along Adam of their own losses.

    Source: Liu, Ramachandran, Liu, Peng: Stein Variational Policy Gradient, 2017; its use for contexts is that of
    Mehta, thesis, 2020, chapter 2. The code released with the latter differs: in place of the kernel's gradient it adds
    one scalar to all of a particle's parameters, and it counts critics into the kernel.

    Args:
        size: n.
        seed: of weights, actions and the beginnings of walks.
        count: N.
        proposals: k, steps of each walk in a round.
        walk: makes the walks.
        particles: makes the actor-critics.
        learning_rate: of Adam, of actors and critics.
        temperature: T, the weight of keeping apart.

    Raises:
        ConfigError: a number is out of its range.
    """

    def __init__(
        self,
        size: int,
        seed: int,
        count: Count,
        proposals: Count,
        walk: Callable[..., Walk],
        particles: Callable[..., Particles],
        learning_rate: Positive,
        temperature: Positive,
    ) -> None:
        self.count, self.proposals, self.learning_rate, self.temperature = count, proposals, learning_rate, temperature
        require_bounds(self, "distribution_learner.svpg", SVPG)
        self._generator = torch.Generator().manual_seed(seed)
        self.particles = particles(count, size, self._generator)
        self.walk = walk(count, size, self._generator)
        self._optimiser = torch.optim.Adam(self._rows, lr=learning_rate)
        self._steps: Sequence[WalkStep] = ()

    @torch.no_grad()
    def propose(self) -> Tensor:
        """Walk k steps on with actions that are drawn; where they led to, shape (N, k, n)."""
        self._steps = [self.walk.step(self._action()) for _ in range(self.proposals)]
        return torch.stack([step.after for step in self._steps], 1)

    def learn(self, rewards: Tensor) -> dict[str, float]:
        """Take one step of Adam.

        Args:
            rewards: of the newest proposals, shape (N, k).

        Returns:
            Figures: the particles' mean distance from each other, and the critics' loss.
        """
        found = self.particles.gradients(self._steps, rewards)
        actors, critics = self._rows
        actors.grad = -ascent_direction(actors.detach(), found.actor, self.temperature)
        critics.grad = found.critic
        self._optimiser.step()
        return {"particle_spread": spread(actors.detach()), "particle_loss": found.loss}

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {
            **self.particles.state_dict(),
            "optimiser": self._optimiser.state_dict(),
            "walk": self.walk.state_dict(),
            "steps": [tuple(step) for step in self._steps],
            "generator": self._generator.get_state(),
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.particles.load_state_dict(state)
        self._optimiser.load_state_dict(state["optimiser"])
        self.walk.load_state_dict(state["walk"])
        self._steps = [WalkStep(*step) for step in state["steps"]]
        self._generator.set_state(state["generator"])

    def inherit(self, state: Mapping[str, Any]) -> None:
        """Take over what the particles of another run have learnt, for walks of their own."""
        self.particles.inherit(state)

    def _action(self) -> Tensor:
        position = self.walk.position
        return self.particles.policy(position).sample(torch.randn(position.shape, generator=self._generator))

    @property
    def _rows(self) -> tuple[torch.nn.Parameter, torch.nn.Parameter]:
        return self.particles.actors.rows, self.particles.critics.rows


def spread(x: Tensor) -> float:
    """Mean distance between particles (n, p); 0 of a single one."""
    return float(torch.pdist(x).mean()) if len(x) > 1 else 0.0
