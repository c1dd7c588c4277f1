"""Inertias of bodies that are free as a whole, written into a batch's fields instead of being compiled."""

from collections.abc import Callable, Sequence

import mujoco
import numpy as np
from mujoco.batch import MODEL_FIELDS, Batch
from numpy.typing import NDArray

from dr_lab.errors import ModelError
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.inertial import BodyInertial
from dr_lab.trajectory import Array

_CLOSE = 1e-9  # share of a field's largest entry that rounding may differ by
_PROBES = (0.37, 0.61, 0.83)  # of the bounds, one after the other; any values that are not nominal would do


class BodyContexts:
    """Writes mass, centre and inertia of free bodies beside compiled contexts of all else.

    A Jacobian by ten parameters of every body of an arm asks for some hundred contexts, which differ in these bodies
    alone: compiling them takes longer than simulating them.

    Args:
        space: the contexts.
        bodies: the free ones.
        compiled: the layout.
    """

    def __init__(self, space: ContextSpace, bodies: Sequence[BodyInertial], compiled: mujoco.MjModel) -> None:
        self._bodies = [(compiled.body(each.body).id, each) for each in bodies]
        self._columns = {p.name: space.index(p.name) for each in bodies for p in each.parameters}
        self._nominal = space.nominal

    def rest(self, z: Array) -> Array:
        """The contexts z, shape (n, parameters), with the bodies as in the model file."""
        rest, columns = z.copy(), list(self._columns.values())
        rest[:, columns] = self._nominal[columns]
        return rest

    def write(self, batch: Batch, z: Array, rows: NDArray[np.intp]) -> None:
        """Write the bodies of contexts z, shape (len(rows), parameters), and what MuJoCo derives from them."""
        values = {name: z[:, column] for name, column in self._columns.items()}
        for row, body in self._bodies:
            for name, value in body.fields(values).items():
                batch.expand(name)[rows, row] = value
        batch.set_const(rows)


def apart(space: ContextSpace, bodies: Sequence[BodyInertial], compiled_at: Callable[[Array], mujoco.MjModel]) -> bool:
    """Whether bodies that are written into fields give what compiling the context gives.

    They do, unless an effect edits or reads the bodies' inertia; a context far from nominal in all parameters tells.

    Args:
        space: the contexts.
        bodies: the free ones.
        compiled_at: the compiled model at a context.
    """
    probe = space.from_unit(np.resize(_PROBES, len(space.names)))
    try:
        whole = compiled_at(probe)
        contexts = BodyContexts(space, bodies, whole)
        plain = compiled_at(contexts.rest(probe[None])[0])
    except ModelError:
        return False
    batch = Batch(plain, 1, 1)
    contexts.write(batch, probe[None], np.zeros(1, np.intp))
    return all(_alike(batch.expand(name)[0], field_of(whole, name)) for name in MODEL_FIELDS)


def _alike(written: Array, compiled: Array) -> bool:
    if np.array_equal(written, compiled):  # nearly all are
        return True
    first, second = written.astype(np.float64), compiled.astype(np.float64)
    return np.allclose(first, second, rtol=0.0, atol=_CLOSE * float(np.abs(second).max(initial=0.0)))


def field_of(model: mujoco.MjModel, name: str) -> Array:
    """A field of a model by the name that a batch has for it."""
    return np.asarray(getattr(model.opt, name[4:]) if name.startswith("opt.") else getattr(model, name))
