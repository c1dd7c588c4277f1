"""Changes of the windows' starts that obey constraints: closed chains stay closed, wheels stay on the ground."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dr_lab.trajectory import Array

SINGULAR = 1e-6  # of the largest singular value: below it a direction is free


def following(free: Array, dofs: Sequence[int]) -> Array:
    """Velocities (…, nv, n) while one of n degrees of freedom moves by 1, of those that directions (…, nv, k) span."""
    return free @ np.linalg.pinv(free[..., list(dofs), :], rcond=SINGULAR)


class Tangent(NamedTuple):
    """Changes of a state that obey the constraints, for w windows, as k unknowns of standard deviation 1.

    Attributes:
        basis: of changes of positions and velocities in the tangent space, shape (w, 2 nv, k).
        inverse: the unknowns that a change is, without its part that breaks a constraint, shape (w, k, 2 nv).
    """

    basis: Array
    inverse: Array

    @property
    def velocities(self) -> Array:
        """Directions in which the velocities can change, shape (w, nv, k / 2)."""
        _, states, unknowns = self.basis.shape
        return self.basis[:, states // 2 :, unknowns // 2 :]

    def pick(self, rows: NDArray[np.intp]) -> "Tangent":
        """The changes of some windows."""
        return Tangent(self.basis[rows], self.inverse[rows])


def tangent(jacobians: Sequence[Array], std: Array) -> Tangent:
    """The null spaces of w windows' Jacobians (r, nv), in units of the standard deviations (2 nv,).

    All have as many directions as the smallest: where a chain passes a singular position, it has one more.
    """
    scales = std.reshape(2, -1)
    parts = [np.linalg.svd(jacobian * scale)[1:] for jacobian in jacobians for scale in scales]
    rank = max(int((size > SINGULAR * size.max(initial=0.0)).sum()) for size, _ in parts)
    free = np.stack([rows[rank:].T for _, rows in parts])  # (2 w, nv, k / 2)
    (count, nv, half), basis = free.shape, np.zeros((len(jacobians), 2 * free.shape[1], 2 * free.shape[2]))
    inverse = np.zeros((len(jacobians), 2 * half, 2 * nv))
    for k, scale in enumerate(scales):
        rows, columns = slice(k * nv, (k + 1) * nv), slice(k * half, (k + 1) * half)
        basis[:, rows, columns] = free[k:count:2] * scale[:, None]
        inverse[:, columns, rows] = (free[k:count:2] / scale[:, None]).transpose(0, 2, 1)
    return Tangent(basis, inverse)
