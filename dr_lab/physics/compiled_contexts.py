"""Compiled models written into a batch as per-simulation fields, beside which single fields may still be changed."""

from collections.abc import Sequence

import mujoco
import numpy as np
from mujoco.batch import MODEL_FIELDS, Batch
from numpy.typing import NDArray

from dr_lab.physics.body_contexts import BodyContexts, field_of
from dr_lab.physics.stepper import CHANGED
from dr_lab.trajectory import Array


class CompiledContexts:
    """Gives each simulation of a batch its own compiled model, field by field.

    `Batch.set_models` takes whole models but then lets no field be changed from step to step. Fields that a compiler
    derives are among those written, so nothing is left to compute. What laws changed from step to step is put back in
    all simulations, whether they get another model or not.

    Args:
        batch: the simulations.
        compiled: the batch's model.
        bodies: what is written beside the models, which then have these bodies as in the file; None where they are
            compiled as well.
    """

    def __init__(self, batch: Batch, compiled: mujoco.MjModel, bodies: BodyContexts | None) -> None:
        self.bodies = bodies
        self._batch = batch
        self._compiled = compiled
        self._expanded = set(CHANGED)
        self._own = packed(compiled)
        self._differed = np.zeros(len(self._own), bool)  # bytes in which a model differed from the batch's
        self._unchanged: dict[str, Array] = {}

    def write(self, models: Sequence[mujoco.MjModel], rows: NDArray[np.intp], z: Array) -> None:
        """Write the models of some simulations, one for each row; the same model may stand for many.

        Args:
            models: of the rows.
            rows: places of the simulations.
            z: their contexts, shape (len(rows), parameters), from which `bodies` are written.
        """
        for name, values in self._unchanged.items():
            self._batch.expand(name)[:] = values
        unique, which = distinct(models)
        for model in unique:
            self._expand_for(model)
        for name in self._expanded:
            self._batch.expand(name)[rows] = np.array([field_of(model, name) for model in unique])[which]
        if self.bodies is not None:
            self.bodies.write(self._batch, z, rows)
        self._unchanged = {name: self._batch.expand(name).copy() for name in CHANGED}

    def _expand_for(self, model: mujoco.MjModel) -> None:
        """Note the fields in which a model differs; bytes that differed before belong to fields that are known."""
        found = packed(model)
        alike = len(found) == len(self._own)
        if alike:
            new = (found != self._own) & ~self._differed
            if not new.any():
                return
            self._differed |= new
        self._expanded |= {
            name for name in MODEL_FIELDS if (field_of(model, name) != field_of(self._compiled, name)).any()
        }


def packed(model: mujoco.MjModel) -> NDArray[np.uint8]:
    """All of a model as bytes, in MuJoCo's order."""
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer


def distinct(models: Sequence[mujoco.MjModel]) -> tuple[list[mujoco.MjModel], NDArray[np.intp]]:
    """The models that are different objects, and for each of the n models which of them it is, shape (n,)."""
    unique = list({id(model): model for model in models}.values())
    row = {id(model): k for k, model in enumerate(unique)}
    return unique, np.array([row[id(model)] for model in models])
