"""Contexts written into a batch's expanded model fields, without recompiling."""

from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from dr_lab.physics.model import Model
from dr_lab.physics.target import FieldEdit
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class _Write:
    column: int
    edit: FieldEdit
    nominal: float


class FieldContexts:
    """Writes contexts z as per-simulation fields of a `Batch`, starting from the nominal values every time.

    Attributes:
        needs_constants: whether derived constants must be recomputed (`Batch.set_const`) after a write.
    """

    def __init__(self, model: Model, compiled: mujoco.MjModel) -> None:
        space = model.space
        self._writes = [
            _Write(column, edit, parameter.nominal)
            for column, parameter in enumerate(space.parameters)
            for edit in model.targets[parameter.name].fields(compiled)
        ]
        names = {write.edit.field for write in self._writes}
        self._nominal = {name: _field(compiled, name) for name in names}
        self.needs_constants = any(n in mujoco.MjModel._setconst_inputs or n.startswith("opt.") for n in names)

    @staticmethod
    def possible(model: Model, compiled: mujoco.MjModel) -> bool:
        """Whether every parameter of the model is a compiled field (no effect, no size, no density)."""
        if model.effects:
            return False
        relative = [p for p in model.declared if any(e.relative for e in model.targets[p.name].fields(compiled))]
        return all(model.targets[p.name].fields(compiled) for p in model.declared) and all(
            p.nominal != 0 for p in relative
        )

    def write(self, batch: Batch, z: Array, ids: NDArray[np.intp]) -> None:
        """Write contexts z, shape (len(ids), n), into the simulations `ids`."""
        for name, nominal in self._nominal.items():
            batch.expand(name)[ids] = nominal
        for write in self._writes:
            where = (ids, *write.edit.index)
            field = batch.expand(write.edit.field)
            value = z[:, write.column]
            if write.edit.relative:
                factor = (value / write.nominal).reshape(-1, *[1] * (field[where].ndim - 1))
                field[where] = field[where] * factor
            else:
                field[where] = value
        if self.needs_constants:
            batch.set_const(ids)


def _field(compiled: mujoco.MjModel, name: str) -> Array:
    if name.startswith("opt."):
        return np.array(getattr(compiled.opt, name[4:]))
    return np.array(getattr(compiled, name))
