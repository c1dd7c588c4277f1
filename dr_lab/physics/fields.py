"""Contexts written into a batch's expanded model fields, without recompiling."""

from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from dr_lab.physics.address import FieldEdit, Turn
from dr_lab.physics.attribute import turned
from dr_lab.physics.few import in_calls
from dr_lab.physics.inertial import FIELDS
from dr_lab.physics.model import Model
from dr_lab.physics.shared_target import SharedTarget
from dr_lab.physics.target import Target
from dr_lab.trajectory import Array

Columns = NDArray[np.intp]
_INERTIAL = ("body_mass", "body_inertia")


@dataclass(frozen=True)
class _Pass:
    """Entries of one field that one write reaches, as value / reference · factor, times what was there where `onto`.

    In this order a value that is its reference leaves the nominal entry to the last bit.
    """

    entries: Columns
    columns: Columns
    reference: Array
    factor: Array
    onto: NDArray[np.bool_] | None


class FieldContexts:
    """Writes contexts z as per-simulation fields of a `Batch`, from the nominal values every time.

    A compiler refuses a body that can move but has, together with what is welded to it, no mass or inertia of at least
    `mujoco.mjMINVAL`; so do these, where it is among what is written.

    Attributes:
        needs_constants: whether derived constants must be recomputed (`Batch.set_const`) after a write.
    """

    def __init__(self, model: Model, compiled: mujoco.MjModel) -> None:
        edits = [
            (column, edit, nominal)
            for column, (place, nominal) in enumerate(_nominal(model))
            for edit in place.fields(compiled)
            if isinstance(edit, FieldEdit)
        ]
        names = dict.fromkeys(edit.field for _, edit, _ in edits)
        self._turns = [
            (column, edit)
            for column, place in enumerate(model.places)
            for edit in place.fields(compiled)
            if isinstance(edit, Turn)
        ]
        self._nominal = {edit.field: _field(compiled, edit.field) for _, edit in self._turns}
        self._bodies = [(compiled.body(each.body).id, each) for each in model.inertials]
        self._passes = {
            name: _passes([each for each in edits if each[1].field == name], _field(compiled, name)) for name in names
        }
        self._model = model
        self._moving = _moving(compiled, [edit for _, edit, _ in edits])
        written = {*names, *self._nominal, *(FIELDS if self._bodies else ())}
        self.needs_constants = any(n in mujoco.MjModel._setconst_inputs or n.startswith("opt.") for n in written)

    @staticmethod
    def possible(model: Model, compiled: mujoco.MjModel) -> bool:
        """Whether every parameter of the model is a compiled field (no effect, no size, no density)."""
        if model.effects:
            return False
        each = [(place.fields(compiled), nominal) for place, nominal in _nominal(model)]
        return all(edits and (nominal != 0 or not any(map(_relative, edits))) for edits, nominal in each)

    def write(self, batch: Batch, z: Array, ids: NDArray[np.intp]) -> NDArray[np.bool_]:
        """Write contexts z, shape (len(ids), n), into the simulations `ids`.

        Returns:
            Which of them are impossible, shape (len(ids),); those got the nominal values.
        """
        self._write(batch, z, ids)
        impossible = self._impossible(batch, ids)
        if impossible.any():
            self._write(batch, np.tile(self._model.space.nominal, (impossible.sum(), 1)), ids[impossible])
        if self.needs_constants:
            for each in in_calls(batch, ids):
                batch.set_const(each)
        return impossible

    def _write(self, batch: Batch, z: Array, ids: NDArray[np.intp]) -> None:
        rows, placed = ids[:, None], self._model.placed(z)
        for name, passes in self._passes.items():
            field = batch.expand(name).reshape(batch.nsim, -1)
            for each in passes:
                value = placed[:, each.columns] / each.reference * each.factor
                if each.onto is not None:
                    value = np.where(each.onto, field[rows, each.entries] * value, value)
                field[rows, each.entries] = value
        self._turn(batch, placed, ids)
        values = self._model.values(z) if self._bodies else {}
        for row, body in self._bodies:
            for name, value in body.fields(values).items():
                batch.expand(name)[ids, row] = value

    def _turn(self, batch: Batch, placed: Array, ids: NDArray[np.intp]) -> None:
        """Turn bodies and axes from where they are nominally, one angle after the other."""
        for name in self._nominal:
            for row in {edit.row for _, edit in self._turns if edit.field == name}:
                batch.expand(name)[ids, row] = self._nominal[name][row]
        for column, edit in self._turns:
            field = batch.expand(edit.field)
            field[ids, edit.row] = turned(edit.field, field[ids, edit.row], edit.axis, placed[:, column])

    def _impossible(self, batch: Batch, ids: NDArray[np.intp]) -> NDArray[np.bool_]:
        found = np.zeros(len(ids), bool)
        if self._moving:
            mass, inertia = (batch.expand(name)[ids] for name in _INERTIAL)
            least = np.minimum(mass, inertia.min(axis=2))
            for welded in self._moving:
                found |= ~(least[:, welded].max(axis=1) >= mujoco.mjMINVAL)  # not <, for NaN is impossible too
        return found


def _nominal(model: Model) -> Iterator[tuple[Target | SharedTarget, float]]:
    """Where the model's values go, each with the nominal one."""
    return zip(model.places, model.placed(model.space.nominal[None])[0].tolist(), strict=True)


def _relative(edit: FieldEdit | Turn) -> bool:
    return isinstance(edit, FieldEdit) and edit.relative


def _moving(compiled: mujoco.MjModel, edits: list[FieldEdit]) -> list[Columns]:
    """The bodies that can move and whose mass or inertia is edited, each with those welded to it."""
    edited = {compiled.body_weldid[edit.index[0]] for edit in edits if edit.field in _INERTIAL}
    return [np.flatnonzero(compiled.body_weldid == body) for body in edited if compiled.body_dofnum[body]]


def _passes(edits: list[tuple[int, FieldEdit, float]], nominal: Array) -> list[_Pass]:
    """The edits of one field, gathered so that no pass writes an entry twice."""
    place, values = np.arange(nominal.size).reshape(nominal.shape), nominal.ravel()
    gathered: list[list[tuple[int, int, float, float, bool]]] = []
    written: dict[int, int] = {}  # entry -> first pass that has it no more
    for column, edit, reference in edits:
        entries = [int(entry) for entry in np.ravel(place[edit.index])]
        position = max(written.get(entry, 0) for entry in entries)
        if position == len(gathered):
            gathered.append([])
        for entry in entries:
            onto = edit.relative and entry in written
            start = values[entry] if edit.relative and not onto else 1.0
            gathered[position].append((entry, column, reference if edit.relative else 1.0, start, onto))
        written |= dict.fromkeys(entries, position + 1)
    return [_gather(each) for each in gathered]


def _gather(entries: list[tuple[int, int, float, float, bool]]) -> _Pass:
    place, column, reference, factor, onto = (np.array(values) for values in zip(*entries, strict=True))
    return _Pass(place, column, reference, factor, onto if onto.any() else None)


def _field(compiled: mujoco.MjModel, name: str) -> Array:
    if name.startswith("opt."):
        return np.array(getattr(compiled.opt, name[4:]))
    return np.array(getattr(compiled, name))
