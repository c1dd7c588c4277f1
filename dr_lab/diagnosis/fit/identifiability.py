"""Can the data show an effect at all, and could the free parameters take its place?"""

from dataclasses import dataclass, field

import numpy as np

from dr_lab.diagnosis.fit.normal_equations import NormalEquations, inverse_root
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Identifiability:
    """Predicted Δχ² of an effect over the width of its bounds, to first order.

    Attributes:
        alone: with all other parameters held; below the evidence threshold the data do not excite the effect.
        beside: with the other parameters free to take its place.
        replacement: how far the others move to do so, in widths of their bounds for a full width of the effect, (n,).
    """

    alone: float
    beside: float
    replacement: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def share(self) -> float:
        """Share of the effect's information that no other parameter can absorb."""
        return self.beside / self.alone if self.alone > 0 else 0.0


def identifiability(equations: NormalEquations, effect_parameters: int) -> Identifiability:
    """Information about the last `effect_parameters` unknowns, whose unit is the width of their bounds.

    I_beside = I_φφ − I_φθ I_θθ⁻¹ I_θφ (Schur complement), the states being eliminated; both figures are largest
    eigenvalues. The weak prior is part of I_θθ only, so a parameter that the data do not move absorbs nothing. The
    replacement is −I_θθ⁻¹ I_θφ e for the combination e of the effect's parameters that the data show best.
    """
    total = equations.reduced.information
    n = len(total) - effect_parameters
    alone = total[n:, n:]
    root = inverse_root(total[:n, :n], equations.prior[:n])
    replaced = root.T @ total[:n, n:]
    beside = alone - replaced.T @ replaced
    values, vectors = np.linalg.eigh(alone)
    return Identifiability(
        alone=float(values[-1]),
        beside=max(float(np.linalg.eigvalsh(beside)[-1]), 0.0),
        replacement=-root @ replaced @ vectors[:, -1],
    )
