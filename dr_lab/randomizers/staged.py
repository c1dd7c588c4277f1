"""One of several distributions at a time: the stages of a curriculum."""

from collections.abc import Callable, Mapping, Sequence
from typing import cast

import numpy as np
import torch
from torch import Tensor, nn

from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.randomizer import Density, shared_edges
from dr_lab.trajectory import Array


class StagedRandomizer(Density):
    """p(z) = p_k(z), k being the present stage; `distribution_learner=curriculum` goes from one to the next.

    Attributes:
        stages: the p_k, by name.

    Args:
        space: the parameters.
        stages: by name, what makes a randomizer over a space; the first is the present one until `enter` is called.

    Raises:
        ConfigError: there is none.
    """

    number: Tensor

    def __init__(self, space: ContextSpace, stages: Mapping[str, Callable[[ContextSpace], Density]]) -> None:
        super().__init__(space)
        if not stages:
            raise ConfigError(
                "randomizer.stages is empty; expected one distribution at least, by name, e.g. with "
                "+randomizer@randomizer.stages.low=uniform"
            )
        self.names = tuple(stages)
        self.stages = nn.ModuleList([make(space) for make in stages.values()])
        self.register_buffer("number", torch.zeros((), dtype=torch.int64))

    @property
    def stage(self) -> str:
        """Name of the present stage."""
        return self.names[int(self.number)]

    def enter(self, stage: str) -> None:
        """Draw from this stage from here on.

        Raises:
            UnknownNameError: there is no such stage.
        """
        if stage not in self.names:
            raise UnknownNameError("stage", stage, self.names, "randomizer.stages")
        self.number.fill_(self.names.index(stage))

    def sample(self, rngs: Sequence[np.random.Generator]) -> Array:
        """A draw of the present stage from each stream."""
        return self._present.sample(rngs)

    def log_prob(self, z: Tensor) -> Tensor:
        """That of the present stage."""
        return self._present.log_prob(z)

    def edges(self, axis: int) -> Array:
        """Those of the stages where they are the same."""
        found = shared_edges([cast(Density, stage) for stage in self.stages], axis)
        return super().edges(axis) if found is None else found

    def shares(self, axis: int, edges: Array) -> Array:
        """Those of the present stage."""
        return self._present.shares(axis, edges)

    def moments(self) -> tuple[Array, Array] | None:
        """Those of the present stage."""
        return self._present.moments()

    @property
    def _present(self) -> Density:
        return cast(Density, self.stages[int(self.number)])
