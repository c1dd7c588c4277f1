"""Contexts written into a batch's expanded model fields, without recompiling."""

from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from dr_lab.physics.model import Model
from dr_lab.physics.target import FieldEdit
from dr_lab.trajectory import Array

Columns = NDArray[np.intp]


@dataclass(frozen=True)
class _Pass:
    """Entries of one field that one write reaches; what is written is value · factor, or nominal · value · factor."""

    entries: Columns
    columns: Columns
    factor: Array
    relative: NDArray[np.bool_]


class FieldContexts:
    """Writes contexts z as per-simulation fields of a `Batch`, starting from the nominal values every time.

    Attributes:
        needs_constants: whether derived constants must be recomputed (`Batch.set_const`) after a write.
    """

    def __init__(self, model: Model, compiled: mujoco.MjModel) -> None:
        edits = [
            (column, edit, 1.0 / parameter.nominal if edit.relative else 1.0)
            for column, parameter in enumerate(model.space.parameters)
            for edit in model.targets[parameter.name].fields(compiled)
        ]
        names = dict.fromkeys(edit.field for _, edit, _ in edits)
        self._nominal = {name: _field(compiled, name) for name in names}
        self._passes = {name: _passes([e for e in edits if e[1].field == name], self._nominal[name]) for name in names}
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
            rows = np.tile(nominal.ravel(), (len(ids), 1))
            for each in self._passes[name]:
                value = z[:, each.columns] * each.factor
                rows[:, each.entries] = np.where(each.relative, rows[:, each.entries] * value, value)
            batch.expand(name)[ids] = rows.reshape(-1, *nominal.shape)
        if self.needs_constants:
            batch.set_const(ids)


def _passes(edits: list[tuple[int, FieldEdit, float]], nominal: Array) -> list[_Pass]:
    """The edits of one field, gathered so that no pass writes an entry twice."""
    place = np.arange(nominal.size).reshape(nominal.shape)
    gathered: list[list[tuple[int, int, float, bool]]] = []
    for column, edit, factor in edits:
        entries = [(int(e), column, factor, edit.relative) for e in np.ravel(place[edit.index])]
        taken = [i for i, p in enumerate(gathered) if {e[0] for e in entries} & {e[0] for e in p}]
        position = taken[-1] + 1 if taken else 0
        if position == len(gathered):
            gathered.append([])
        gathered[position].extend(entries)
    return [_Pass(*(np.array(values) for values in zip(*p, strict=True))) for p in gathered]


def _field(compiled: mujoco.MjModel, name: str) -> Array:
    if name.startswith("opt."):
        return np.array(getattr(compiled.opt, name[4:]))
    return np.array(getattr(compiled, name))
