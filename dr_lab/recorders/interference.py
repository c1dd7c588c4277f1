"""How the policy gradients of contexts agree in the mean of several runs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dr_lab.recorders.training import ContextAxis, Matrix
from dr_lab.reports.quantity import counted
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Interference:
    """Cosines between the policy gradients of every two contexts, over the runs of a group.

    Attributes:
        group: whose they are.
        runs: of the group.
        frames: control steps that the policies were trained for, mean of the runs.
        axis: the contexts.
        mean: shape (n, n); NaN where no run knows it.
        spread: standard deviation over the runs, shape (n, n); NaN of one run.
        doubtful: whether the sign of the mean is in doubt, shape (n, n).
    """

    group: str
    runs: int
    frames: int
    axis: ContextAxis
    mean: Array
    spread: Array
    doubtful: NDArray[np.bool_]

    @property
    def told(self) -> str:
        """Of how many runs it is."""
        return counted(self.runs, "run")

    @property
    def matrix(self) -> Matrix:
        """The mean, as recordings draw it."""
        return Matrix(f"{self.frames} steps, {self.group}", self.axis, self.mean, self.doubtful)
