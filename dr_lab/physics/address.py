"""Where a scalar of the physics stands in a model, and what its value does to fields of the compiled one."""

from dataclasses import dataclass
from typing import Any

import mujoco

from dr_lab.errors import UnknownNameError

_DOFS = {mujoco.mjtJoint.mjJNT_FREE: 6, mujoco.mjtJoint.mjJNT_BALL: 3}


@dataclass(frozen=True)
class FieldEdit:
    """How a value enters a compiled model field.

    Attributes:
        field: name accepted by `mujoco.batch.Batch.expand`.
        index: entries of one simulation's field that are written.
        relative: multiply the entries by value / nominal instead of setting them.
    """

    field: str
    index: tuple[int | slice, ...]
    relative: bool


@dataclass(frozen=True)
class Turn:
    """How an angle enters a compiled model field: it turns what stands there about one axis of the body.

    Several turns of one row act one after the other, each about the axis that the ones before it left.

    Attributes:
        field: ``body_quat``, turned from the right, or ``jnt_axis``.
        row: of the body or joint.
        axis: 0, 1 or 2.
    """

    field: str
    row: int
    axis: int


@dataclass(frozen=True)
class Address:
    """The parts of a target's text, ``kind.element.attribute[index]``."""

    kind: str
    element: str
    attribute: str
    index: int

    def __str__(self) -> str:
        """The text form."""
        middle = f"{self.element}." if self.element else ""
        return f"{self.kind}.{middle}{self.attribute}[{self.index}]"

    def part(self, spec: mujoco.MjSpec) -> Any:  # noqa: ANN401 (MjSpec elements share no public base class)
        """The element in a spec.

        Raises:
            UnknownNameError: it is not in the model; the message lists those of its kind.
        """
        if self.kind == "option":
            return spec.option
        element = getattr(spec, self.kind)(self.element)
        if element is None:
            names = [e.name for e in _elements(spec, self.kind) if e.name]
            raise UnknownNameError(self.kind, self.element, names, f"model {spec.modelname!r}")
        return element

    def row(self, model: mujoco.MjModel) -> int:
        """The element's row in a compiled model."""
        return int(getattr(model, self.kind)(self.element).id)

    def dofs(self, model: mujoco.MjModel) -> slice:
        """Degrees of freedom of the joint."""
        row = self.row(model)
        first = int(model.jnt_dofadr[row])
        return slice(first, first + _DOFS.get(mujoco.mjtJoint(int(model.jnt_type[row])), 1))


def _elements(spec: mujoco.MjSpec, kind: str) -> list[Any]:
    """All elements of a kind ("body", "joint", "geom", "actuator") in the spec."""
    return list({"body": spec.bodies, "joint": spec.joints, "geom": spec.geoms, "actuator": spec.actuators}[kind])
