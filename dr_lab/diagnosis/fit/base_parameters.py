"""Which combinations of the inertial parameters the logs know: numerical base parameters of a fit."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from dr_lab.diagnosis.fit.normal_equations import NormalEquations, inverse_root
from dr_lab.trajectory import Array

HALF = 0.5  # of the prior's standard deviation, below which logs and not the prior tell a combination
_ROUNDING = 1e-9  # share of the strongest combination's information below which finite differences show nothing
_SHOWN = 0.3  # entries of a combination, whose length is 1, that are told
_TOLD = 3  # combinations


@dataclass(frozen=True)
class BaseParameters:
    """What logs know of some parameters, all others free.

    Attributes:
        count: number of the parameters.
        rank: number of independent combinations that change the outputs at all.
        known: number of these whose standard deviation is at most half of the prior's.
        condition: ratio of the largest to the smallest standard deviation that the logs alone would give the known
            combinations, in standard deviations of the prior; 1 where none is known.
        chosen: as many parameters as are known that tell the known combinations together best, by pivoting.
        held: parameters whose own standard deviation stays above half of the prior's: the prior holds them.
        best: the combinations that the logs know best, the best first, by parameter; their length is 1.
        worst: the same of those that they know least, the worst of those that change the outputs first.
    """

    count: int
    rank: int
    known: int
    condition: float
    chosen: tuple[str, ...]
    held: tuple[str, ...]
    best: tuple[dict[str, float], ...]
    worst: tuple[dict[str, float], ...]


def base_parameters(equations: NormalEquations, names: Sequence[str], rows: NDArray[np.intp]) -> BaseParameters:
    """Base parameters among some of a fit's parameters, at the fitted context.

    With the information I of the fit, starts and other parameters eliminated, and the prior's precision P, the
    eigenvectors of P^(-1/2) I P^(-1/2) are the combinations and an eigenvalue λ says how well the logs know one: its
    standard deviation is 1/√(1 + λ) of the prior's. Pivoted QR of the square root picks parameters that tell the known
    combinations: the others are told only in sums with these.

    Source: Gautier, Journal of Robotic Systems 8 (1991) 485 (numerical base parameters by QR and SVD).

    Args:
        equations: of the fit.
        names: names of all its parameters.
        rows: places of those that are looked at.
    """
    information = equations.reduced.information
    others = np.setdiff1d(np.arange(len(names)), rows)
    root = inverse_root(information[np.ix_(others, others)], equations.prior[others])
    absorbed = root.T @ information[np.ix_(others, rows)]
    scale = equations.prior[rows] ** -0.5
    beside = (information[np.ix_(rows, rows)] - absorbed.T @ absorbed) * scale * scale[:, None]
    values, vectors = np.linalg.eigh(beside)
    values, vectors = np.maximum(values[::-1], 0.0), vectors[:, ::-1]
    rank = int((values > _ROUNDING * values[0]).sum())
    known = min(int((values >= HALF**-2 - 1).sum()), rank)
    told = [str(names[row]) for row in rows.tolist()]
    square = np.sqrt(values[:known, None]) * vectors[:, :known].T
    order = _pivots(square) if known else []
    share = (vectors**2 / (1 + values)).sum(1)
    return BaseParameters(
        count=len(rows),
        rank=rank,
        known=known,
        condition=float(np.sqrt(values[0] / values[known - 1])) if known else 1.0,
        chosen=tuple(told[k] for k in sorted(order[:known])),
        held=tuple(name for name, variance in zip(told, share, strict=True) if variance > HALF**2),
        best=tuple(combination(vectors[:, k], told, 1) for k in range(min(_TOLD, known))),
        worst=tuple(combination(vectors[:, k], told, 1) for k in range(rank - 1, max(known, rank - _TOLD) - 1, -1)),
    )


def _pivots(columns: Array) -> list[int]:
    """Columns in the order in which pivoted QR takes them."""
    found: Any = qr(columns, mode="r", pivoting=True)  # SciPy types each of its many answers
    return [int(place) for place in found[-1]]


def combination(vector: Array, names: Sequence[str], least: int = 0) -> dict[str, float]:
    """A combination of parameters whose length is 1, by name, the largest first and positive, without small entries.

    Args:
        vector: its entries, shape (n,).
        names: of the parameters.
        least: entries that are told however small they are.
    """
    order = np.argsort(-np.abs(vector))
    sign = np.sign(vector[order[0]])
    shown = (k for place, k in enumerate(order) if place < least or abs(vector[k]) >= _SHOWN)
    return {names[int(k)]: float(sign * vector[k]) for k in shown}
