"""What is thought of the windows' initial states before they are fitted."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.windows.channels import Channel
from dr_lab.diagnosis.windows.tangent import Tangent, following
from dr_lab.trajectory import Array

_DEPENDENT = 1e-3  # of a singular value: joints of a closed chain whose motions differ by less move together


@dataclass(frozen=True)
class StartPrior:
    """Gaussian prior of the windows' initial states.

    Attributes:
        qpos: mean positions, shape (w, nq).
        qvel: mean velocities, shape (w, nv).
        qacc: mean accelerations, which tell the state a little earlier or later, shape (w, nv).
        std: prior standard deviations of the unknowns: s of the state, then the k activations that nothing before the
            start tells, then what commands did between their samples, shape (s + k + u,).
        tangent: what the unknowns of the state do where chains are closed, or bodies stay on the ground; None where
            they are changes of the positions and velocities in the tangent space, s = 2 nv.
        grounded: whether bodies stay on the ground.
    """

    qpos: Array
    qvel: Array
    qacc: Array
    std: Array
    tangent: Tangent | None = None
    grounded: bool = False

    @property
    def nstate(self) -> int:
        """Number s of unknowns of the state."""
        return 2 * self.qvel.shape[1] if self.tangent is None else self.tangent.basis.shape[2]

    def pick(self, rows: NDArray[np.intp]) -> "StartPrior":
        """The prior of some windows."""
        kept = {name: getattr(self, name)[rows] for name in ("qpos", "qvel", "qacc")}
        return replace(self, tangent=self.tangent and self.tangent.pick(rows), **kept)

    def change(self, unknowns: Array, moved: Array) -> Array:
        """Changes of positions and velocities: those of unknowns (…, w, s or more), and others (…, w, 2 nv).

        Of the others only what opens no chain and leaves no ground counts.
        """
        of_state = unknowns[..., : self.nstate]
        if self.tangent is None:
            return of_state + moved
        along = of_state + np.einsum("wks,...ws->...wk", self.tangent.inverse, moved)
        return np.einsum("wsk,...wk->...ws", self.tangent.basis, along)

    def unknowns(self, change: Array) -> Array:
        """The unknowns that changes of positions and velocities (…, w, 2 nv) are, as far as they keep to it."""
        return change if self.tangent is None else np.einsum("wks,...ws->...wk", self.tangent.inverse, change)

    def reported(self, channels: Sequence[Channel]) -> Iterator[tuple[Channel, list[int], Array]]:
        """What channels report of the starts of their joints: those of positions, or of velocities where these lack.

        Yields:
            The channel, the changes of positions and velocities that it tells, and its value, slope and curvature,
            shape (3, w).
        """
        nv, placed = self.qvel.shape[1], {channel.dof for channel in channels if channel.kind == "position"}
        for channel in channels:
            dof = channel.dof
            if channel.kind == "position":
                found = self.qpos[:, channel.address], self.qvel[:, dof], self.qacc[:, dof]
                yield channel, [dof, nv + dof], np.stack(found)
            elif channel.kind == "velocity" and dof not in placed:
                yield channel, [nv + dof], np.stack([self.qvel[:, dof], self.qacc[:, dof], np.zeros(len(self.qvel))])

    def independent(self, dofs: Sequence[int]) -> list[int]:
        """Those of some degrees of freedom that can move while the ones before them rest, in half of the windows."""
        if self.tangent is None:
            return list(dofs)
        kept = list[int]()
        for dof in dofs:
            rows = self.tangent.velocities[:, [*kept, dof]]
            rows = rows / np.maximum(np.linalg.norm(rows, axis=2, keepdims=True), np.finfo(float).tiny)
            if np.median(np.linalg.matrix_rank(rows, rtol=_DEPENDENT)) > len(kept):
                kept.append(dof)
        return kept

    def carried(self, dofs: Sequence[int]) -> Array:
        """Velocities of all joints while one of some degrees of freedom moves by 1, the others resting, (w, nv, n)."""
        if self.tangent is None:
            return np.broadcast_to(np.eye(self.qvel.shape[1])[:, list(dofs)], (*self.qvel.shape, len(dofs)))
        return following(self.tangent.velocities, dofs)

    def slope(self, slopes: Array, change: Array) -> Array:
        """What changes of positions and velocities (w, 2 nv) do to residuals with slopes (w, m, s or more), (w, m)."""
        return np.einsum("wms,ws->wm", slopes[..., : self.nstate], self.unknowns(change))
