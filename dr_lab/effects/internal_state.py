"""A force law with one internal state for each simulation, as the deflection of bristles or of a spring that yields."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dr_lab.physics.law import MotionLaw
from dr_lab.trajectory import Array


@dataclass
class InternalState(MotionLaw):
    """A law that goes on from one number for each simulation, which is 0 at rest and follows the motion.

    Attributes:
        state: the numbers, shape (n,).
    """

    state: Array = field(default_factory=lambda: np.zeros(1), kw_only=True)

    def of(self, count: int) -> Array:
        """The states of `count` simulations; all are at rest if there were others before."""
        if len(self.state) != count:
            self.state = np.zeros(count)
        return self.state

    def rest(self, rows: NDArray[np.intp]) -> None:
        """Let these simulations begin at rest."""
        if len(self.state) > rows.max(initial=0):
            self.state[rows] = 0.0

    @property
    def memory(self) -> Array:
        """The states, shape (n, 1)."""
        return self.state[:, None]

    def remember(self, memory: Array) -> None:
        """Go on from the `memory` of an equal law."""
        self.state = memory[:, 0].copy()
