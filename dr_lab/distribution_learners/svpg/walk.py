"""The walks of particles through the unit cube."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import torch
from torch import Tensor

from dr_lab.bounds import Count, Positive, require_bounds


class WalkStep(NamedTuple):
    """One step of N walks.

    Attributes:
        before: where they were, shape (N, n).
        action: what was asked for, shape (N, n).
        after: where it led to, shape (N, n).
        cut: whether the walk was cut after it and begins anew elsewhere, shape (N,).
    """

    before: Tensor
    action: Tensor
    after: Tensor
    cut: Tensor


class Walk:
    """N points of [0, 1]ⁿ, each moved by u ← clip(u + d·a/max(1, ‖a‖), 0, 1).

    A walk is cut, and begins anew at a point of U[0, 1]ⁿ, after `horizon` steps or where it does not move. That is no
    end in the sense of its rewards: it would have gone on.

    Source: Mehta, thesis, 2020, appendix A.6. Its released code shortens an action as here where n is 1; where it is
    more it gives every step the length d, so that no walk can stay near a point.

    Attributes:
        position: u, shape (N, n).

    Args:
        count: N.
        size: n.
        generator: random numbers of the beginnings.
        max_step: d, longest step.
        horizon: steps after which a walk is cut.

    Raises:
        ConfigError: a number is out of its range.
    """

    def __init__(self, count: int, size: int, generator: torch.Generator, max_step: Positive, horizon: Count) -> None:
        self.max_step, self.horizon = max_step, horizon
        require_bounds(self, "distribution_learner.svpg.walk", Walk)
        self._generator = generator
        self.position = torch.rand(count, size, generator=generator)
        self._age = torch.zeros(count, dtype=torch.int64)

    def step(self, action: Tensor) -> WalkStep:
        """Move all points by their actions (N, n)."""
        before = self.position
        length = action.norm(dim=-1, keepdim=True).clamp(min=1.0)
        after = (before + self.max_step * action / length).clamp(0.0, 1.0)
        age = self._age + 1  # what `state_dict` has given is not written to
        cut = (age >= self.horizon) | (after == before).all(-1)
        anew = torch.rand(before.shape, generator=self._generator)
        self.position = torch.where(cut[:, None], anew, after)
        self._age = torch.where(cut, 0, age)
        return WalkStep(before, action, after, cut)

    def state_dict(self) -> dict[str, Any]:
        """Where the walks are."""
        return {"position": self.position, "age": self._age}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.position, self._age = state["position"].clone(), state["age"].clone()
