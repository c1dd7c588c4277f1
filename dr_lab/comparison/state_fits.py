"""Fits of windows' states that several parts of a report need, each made once."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import StateFit, fit_roughly, fit_states
from dr_lab.diagnosis.missing_force.residual_force import ResidualForce, residual_forces
from dr_lab.diagnosis.settings import SolverSettings
from dr_lab.diagnosis.windows.channels import Tape
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
        self._tapes: dict[_Key, Tape] = {}
        self._forces: dict[_Key, dict[str, ResidualForce]] = {}

    def __call__(self, model: Model, z: Array, windows: Windows) -> tuple[Replay, StateFit]:
        """The fit of the windows' states under a model at context z (n,), and a replay of the windows.

        The replay is a new one each time, for one that has simulated keeps the memory of its simulations.
        """
        key = self._key(model, z, windows)
        if key not in self._fits:
            self._held += [model, windows]
            self._fits[key] = fit_states(model, z, windows, self._solver, self._threads)[1]
        return Replay(model, windows, self._threads), self._fits[key]

    def rough(self, model: Model, z: Array, windows: Windows) -> tuple[Replay, StateFit, Tape]:
        """The same of windows that are always fitted roughly, and what the model does in them."""
        key = self._key(model, z, windows)
        if key not in self._tapes:
            self._held += [model, windows]
            _, self._fits[key], self._tapes[key] = fit_roughly(model, z, windows, self._solver, self._threads)
        return Replay(model, windows, self._threads), self._fits[key], self._tapes[key]

    def forces(self, model: Model, z: Array, windows: Windows, rows: Places) -> dict[str, ResidualForce]:
        """The force that the model misses at each joint in the windows at these places, always the same of them.

        States are fitted roughly: what they still lack is part of the least squares that give the force.
        """
        key = self._key(model, z, windows)
        if key not in self._forces:
            self._held += [model, windows]
            replay, fit, tape = self._some(model, z, windows, rows)
            self._forces[key] = residual_forces(replay, fit, self._solver, tape)
        return self._forces[key]

    def _some(self, model: Model, z: Array, windows: Windows, rows: Places) -> tuple[Replay, StateFit, Tape]:
        """The rough fit of some windows: part of that of all, where there is one."""
        some, key = windows.pick(rows), self._key(model, z, windows)
        if key not in self._tapes:
            return fit_roughly(model, z, some, self._solver, self._threads)
        known = self._fits[key]
        parts = {name: getattr(known, name)[rows] for name in ("delta", "residuals", "infeasible", "slopes")}
        return Replay(model, some, self._threads), replace(known, **parts), self._tapes[key].pick(rows)

    def _key(self, model: Model, z: Array, windows: Windows) -> _Key:
        return id(model), id(windows), z.tobytes()
