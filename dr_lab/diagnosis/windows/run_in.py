"""Run-in of activations before windows, under each context's own parameters."""

from dataclasses import replace

import mujoco
import numpy as np
from mujoco.batch import MODEL_FIELDS
from numpy.typing import NDArray

from dr_lab.errors import ModelError
from dr_lab.physics.law import History
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

# Fields that lengths, velocities and dynamics of actuators follow from, by the beginning of their names.
_KINEMATICS = ("tendon_", "wrap_", "site_", "geom_", "jnt_axis", "jnt_pos", "body_pos", "body_quat", "qpos0")
_ACTUATION = ("actuator_", *_KINEMATICS)
_DERIVED = ("actuator_acc0", "tendon_invweight0", "geom_rbound")
_KEPT = 64  # contexts whose activations are remembered


class RunIn:
    """Activations at the start of windows, along the motion measured before.

    Contexts that differ in nothing that moves an actuator share one run.

    Args:
        model: the model with its effects.
        history: motion and controls before w windows.
        begin: activations before the first step of the history, shape (w, na).
        threads: C threads; None takes every core.
    """

    def __init__(self, model: Model, history: History, begin: Array, threads: int | None) -> None:
        self._model = model
        self._history = history
        self._begin = begin
        self._threads = threads
        self._telling = _telling(model)
        self._found: dict[bytes, Array] = {}
        self._simulators: dict[int, Simulator] = {}

    def ends(self, z: Array) -> Array:
        """Activations at the windows' starts under contexts z (c, n), shape (c, w, na)."""
        if not self._history.qpos.shape[1]:
            return np.tile(self._begin, (len(z), 1, 1))
        keys = [row[self._telling].tobytes() for row in z]
        new = {key: row for key, row in zip(keys, z, strict=True) if key not in self._found}
        if new:
            if len(self._found) + len(new) > _KEPT:
                self._found = {key: self._found[key] for key in keys if key in self._found}
            ended = self._simulator(len(new)).follow(np.stack(list(new.values())), self._history, self._begin)[-1]
            self._found |= dict(zip(new, ended, strict=True))
        return np.stack([self._found[key] for key in keys])

    def _simulator(self, contexts: int) -> Simulator:
        if contexts not in self._simulators:
            self._simulators[contexts] = Simulator(self._model, contexts * len(self._begin), self._threads)
        return self._simulators[contexts]


def _telling(model: Model) -> NDArray[np.bool_]:
    """Parameters that activations may depend on, shape (n,): those of effects, and those that move an actuator."""
    bare = replace(model, effects=())
    found = np.ones(len(model.space.parameters), bool)
    for k in range(len(bare.space.parameters)):
        ends = np.tile(bare.space.nominal, (2, 1))
        ends[:, k] = bare.space.low[k], bare.space.high[k]
        try:
            found[k] = _differ(*(bare.compile(z) for z in ends))
        except ModelError:  # a bound that does not compile may change anything
            found[k] = True
    return found


def _differ(one: mujoco.MjModel, other: mujoco.MjModel) -> bool:
    names = [name for name in MODEL_FIELDS if name.startswith(_ACTUATION) and name not in _DERIVED]
    return any(not np.array_equal(getattr(one, name), getattr(other, name)) for name in names)
