"""A command as the machine receives it: held between edges."""

from dataclasses import dataclass

import numpy as np

from dr_lab.errors import DataError
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Command:
    """Zero-order hold: value[i] acts from edge[i] until edge[i + 1]; before the first edge it is `before`.

    Attributes:
        edge: times in s, increasing, shape (n,).
        value: in the actuator's unit, shape (n,).
        before: in the actuator's unit.

    Raises:
        DataError: shapes disagree or the edges do not increase.
    """

    edge: Array
    value: Array
    before: float = 0.0

    def __post_init__(self) -> None:
        if self.edge.ndim != 1 or self.edge.shape != self.value.shape:
            shapes = f"edge {self.edge.shape}, value {self.value.shape}"
            raise DataError(f"Command: {shapes}; expected both (n,).")
        if (np.diff(self.edge) <= 0).any():
            raise DataError("Command: its edges must increase.")

    def at(self, time: Array) -> Array:
        """The held value at each time, shape of `time`."""
        index = np.searchsorted(self.edge, time, side="right")
        return np.concatenate([[self.before], self.value])[index]
