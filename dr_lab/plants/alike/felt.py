"""What of a rival the machine's joints feel."""

from dataclasses import dataclass

import numpy as np

from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Felt:
    """From when on a change of the machine counts as felt, as in the catalogue: what is not felt there is no rival.

    Attributes:
        change: of a force, above this share of the largest force of inertia and gravity.
        combination: of several changes, if the weakest combination of them is above this share of the strongest.
    """

    change: float
    combination: float

    def alone(self, changes: list[Array], largest: float) -> list[Array]:
        """Those of some changes that are felt by themselves.

        Args:
            changes: of forces, N·m or N for a unit of what changes.
            largest: force of inertia and gravity.
        """
        return [change for change in changes if float(np.abs(change).max()) > self.change * largest]

    def together(self, changes: list[Array]) -> bool:
        """Whether no combination of some changes goes unfelt."""
        columns = np.stack([change.ravel() for change in changes], axis=1)
        sizes = np.linalg.svd(columns / np.linalg.norm(columns, axis=0).clip(np.finfo(float).tiny), compute_uv=False)
        return len(sizes) == len(changes) and bool(sizes[-1] > self.combination * sizes[0])
