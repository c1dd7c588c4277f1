"""Attributes of a model's elements that a simulation parameter may have as its target."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import mujoco
import numpy as np

from dr_lab.errors import ModelError
from dr_lab.physics.address import Address, FieldEdit, Turn

Element = Any  # MjSpec elements share no public base class
Edits = tuple[FieldEdit | Turn, ...]
_Row = Callable[[Address, mujoco.MjModel], int | slice]


class Attribute(ABC):
    """One kind of scalar, or of a few that an index tells apart.

    Attributes:
        entries: how many there are.
    """

    entries: int = 1

    @abstractmethod
    def read(self, at: Address, spec: mujoco.MjSpec) -> float:
        """Nominal value in the spec.

        Raises:
            ModelError: the element is not of the sort that has the attribute.
        """

    @abstractmethod
    def write(self, at: Address, spec: mujoco.MjSpec, value: float) -> None:
        """Set the value in a fresh spec (the caller's copy)."""

    @abstractmethod
    def fields(self, at: Address, model: mujoco.MjModel) -> Edits:
        """Compiled fields that carry the value, empty where the model must be recompiled."""


@dataclass(frozen=True)
class Entry(Attribute):
    """A number that stands in the spec under the attribute's own name.

    Polynomial damping and stiffness are arrays there, which are addressed by their linear entry.

    Attributes:
        entries: how many may be addressed.
        field: the compiled field, empty where the model must be recompiled.
        row: which row of the field is the element's.
    """

    entries: int = 1
    field: str = ""
    row: _Row = Address.row

    def read(self, at: Address, spec: mujoco.MjSpec) -> float:
        """Nominal value in the spec."""
        value = np.atleast_1d(np.asarray(getattr(at.part(spec), at.attribute), dtype=float))
        return float(value[at.index])

    def write(self, at: Address, spec: mujoco.MjSpec, value: float) -> None:
        """Set the value in a fresh spec."""
        element = at.part(spec)
        if np.ndim(getattr(element, at.attribute)):
            getattr(element, at.attribute)[at.index] = value
        else:
            setattr(element, at.attribute, value)

    def fields(self, at: Address, model: mujoco.MjModel) -> Edits:
        """Compiled fields that carry the value."""
        if not self.field:
            return ()
        entry = (at.index,) if self.entries > 1 else ()
        return (FieldEdit(self.field, (self.row(at, model), *entry), relative=False),)


@dataclass(frozen=True)
class OptionEntry(Entry):
    """A number of the options; there is one row of them."""

    def fields(self, at: Address, model: mujoco.MjModel) -> Edits:
        """Compiled fields that carry the value."""
        del model
        return (FieldEdit(self.field, (at.index,) if self.entries > 1 else (), relative=False),)


@dataclass(frozen=True)
class Angle(Entry):
    """A joint's position, in rad or m; where MJCF angles are degrees, a hinge's is one of them in the spec."""

    def read(self, at: Address, spec: mujoco.MjSpec) -> float:
        """Nominal value in the spec."""
        return super().read(at, spec) * _unit(at, spec)

    def write(self, at: Address, spec: mujoco.MjSpec, value: float) -> None:
        """Set the value in a fresh spec."""
        super().write(at, spec, value / _unit(at, spec))


def _unit(at: Address, spec: mujoco.MjSpec) -> float:
    """The spec's unit of a joint's position in SI."""
    degrees = spec.compiler.degree and at.part(spec).type != mujoco.mjtJoint.mjJNT_SLIDE
    return np.pi / 180 if degrees else 1.0


def position(at: Address, model: mujoco.MjModel) -> int:
    """Row of a joint in fields that are laid out as qpos."""
    return int(model.jnt_qposadr[at.row(model)])


class Askew(Attribute):
    """Angles in rad by which an element sits askew, about the axes of its body; nominal 0, as the file gives it."""

    entries = 3
    field: ClassVar[str]  # of the compiled model; also which kind of orientation it is
    given: ClassVar[str]  # the spec's name of it

    def write(self, at: Address, spec: mujoco.MjSpec, value: float) -> None:
        """Set the value in a fresh spec."""
        part = at.part(spec)
        before = np.asarray(getattr(part, self.given), dtype=float)
        setattr(part, self.given, turned(self.field, before, at.index, np.array(value)))

    def fields(self, at: Address, model: mujoco.MjModel) -> Edits:
        """Compiled fields that carry the value."""
        return (Turn(self.field, at.row(model), at.index),)


class JointTurn(Askew):
    """Of a joint's axis, about the axes of its body."""

    field = "jnt_axis"
    given = "axis"

    def read(self, at: Address, spec: mujoco.MjSpec) -> float:
        """Nominal value in the spec."""
        require_no_frame(at, spec)
        return 0.0


def require_no_frame(at: Address, spec: mujoco.MjSpec) -> None:
    """Check that what the file says of an element's place or axis is what the compiled model holds.

    Raises:
        ModelError: it stands in a <frame>, which moves and turns it.
    """
    if at.part(spec).frame is not None:
        raise ModelError(
            f"Target {at}: {at.kind} {at.element!r} stands in a <frame>, which moves and turns it. Take it out."
        )


def turned(field: str, before: np.ndarray, axis: int, angle: np.ndarray) -> np.ndarray:
    """What a turn leaves of quaternions (…, 4), turned from the right, or of axes (…, 3); angles in rad, (…)."""
    angle = np.asarray(angle)[..., None]
    vector = np.zeros(3)
    vector[axis] = 1.0
    if field == "jnt_axis":
        along, across = vector * before[..., axis, None], np.cross(np.broadcast_to(vector, before.shape), before)
        return along + np.cos(angle) * (before - along) + np.sin(angle) * across
    real, imaginary = before[..., :1], before[..., 1:]
    across = np.cross(imaginary, np.broadcast_to(vector, imaginary.shape))
    moved = np.concatenate([-before[..., 1 + axis, None], real * vector + across], axis=-1)
    return np.cos(angle / 2) * before + np.sin(angle / 2) * moved
