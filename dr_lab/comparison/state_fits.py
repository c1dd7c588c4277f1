"""Fits of windows' states that several parts of a report need, each made once."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import StateFit, fit_states
from dr_lab.diagnosis.missing_force.residual_force import ResidualForce, residual_forces
from dr_lab.diagnosis.settings import SolverSettings
from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array

Places = NDArray[np.intp]
_Key = tuple[int, int, bytes]


class StateFits:
    """Remembers fits by model, context and windows; models and windows are told apart as objects.

    Args:
        solver: settings of the fits.
        threads: C threads.
    """

    def __init__(self, solver: SolverSettings, threads: int) -> None:
        self._solver = solver
        self._threads = threads
        self._held: list[Model | Windows] = []  # so that no other object takes the place of a known one
        self._fits: dict[_Key, StateFit] = {}
        self._forces: dict[_Key, dict[str, ResidualForce]] = {}

    def __call__(self, model: Model, z: Array, windows: Windows, *, rough: bool = False) -> tuple[Replay, StateFit]:
        """The fit of the windows' states under a model at context z (n,), and a replay of the windows.

        The replay is a new one each time, for one that has simulated keeps the memory of its simulations. Whether a
        fit may be rough is not remembered: the same windows are always asked for in the same way.
        """
        key = self._key(model, z, windows)
        if key not in self._fits:
            self._held += [model, windows]
            self._fits[key] = self._fit(model, z, windows, rough=rough)[1]
        return Replay(model, windows, self._threads), self._fits[key]

    def forces(self, model: Model, z: Array, windows: Windows, rows: Places) -> dict[str, ResidualForce]:
        """The force that the model misses at each joint in the windows at these places, always the same of them.

        States are fitted roughly: what they still lack is part of the least squares that give the force.
        """
        key = self._key(model, z, windows)
        if key not in self._forces:
            self._held += [model, windows]
            self._forces[key] = residual_forces(*self._some(model, z, windows, rows), self._solver)
        return self._forces[key]

    def _some(self, model: Model, z: Array, windows: Windows, rows: Places) -> tuple[Replay, StateFit]:
        """The fit of some windows: part of that of all, where there is one."""
        some, known = windows.pick(rows), self._fits.get(self._key(model, z, windows))
        if known is None:
            return self._fit(model, z, some, rough=True)
        parts = {name: getattr(known, name)[rows] for name in ("delta", "residuals", "infeasible", "slopes")}
        return Replay(model, some, self._threads), replace(known, **parts)

    def _fit(self, model: Model, z: Array, windows: Windows, *, rough: bool) -> tuple[Replay, StateFit]:
        """A rough fit keeps the slopes at its start as long as its steps gain, and ends at the rough tolerance."""
        solver = self._solver
        if rough:
            solver = replace(
                solver, state_tolerance=solver.rough_tolerance, refresh=1.0, iterations=solver.start_iterations
            )
        return fit_states(model, z, windows, solver, self._threads)

    def _key(self, model: Model, z: Array, windows: Windows) -> _Key:
        return id(model), id(windows), z.tobytes()
