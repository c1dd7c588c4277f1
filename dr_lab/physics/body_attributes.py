"""What may vary of a body: mass, inertia, centre of mass, and how it sits on its parent."""

from dataclasses import dataclass

import mujoco
import numpy as np

from dr_lab.errors import ModelError
from dr_lab.physics.address import Address, FieldEdit
from dr_lab.physics.attribute import Askew, Attribute, Edits, Element, Entry, require_no_frame

_ROUNDING = 4 * np.finfo(float).eps  # share of a sum, by which those of scaled moments may be off


@dataclass(frozen=True)
class InertialEntry(Entry):
    """A number of a body's <inertial>, which must be there: principal moments, or the centre of mass.

    MuJoCo stores less of the mass matrix of a body whose centre of mass is its origin (``simple``), which no
    centre may then leave; a body whose centre is set is stored whole, at every value.
    """

    def read(self, at: Address, spec: mujoco.MjSpec) -> float:
        """Nominal value in the spec."""
        body = _with_inertial(at, spec)
        if at.attribute == "inertia" and np.isfinite(body.fullinertia[0]):
            raise ModelError(f"Target {at}: body {at.element!r} has a fullinertia. Give it as diaginertia and quat.")
        return super().read(at, spec)

    def write(self, at: Address, spec: mujoco.MjSpec, value: float) -> None:
        """Set the value in a fresh spec."""
        super().write(at, spec, value)
        if at.attribute == "ipos":
            at.part(spec).simple = False


@dataclass(frozen=True)
class BodyPlace(Entry):
    """A body's place on its parent, along the parent's axes."""

    def read(self, at: Address, spec: mujoco.MjSpec) -> float:
        """Nominal value in the spec."""
        require_no_frame(at, spec)
        return super().read(at, spec)


class BodyMass(Attribute):
    """A body's mass, which takes its inertia along: same shape, other density."""

    def read(self, at: Address, spec: mujoco.MjSpec) -> float:
        """Nominal value in the spec."""
        return float(_with_inertial(at, spec).mass)

    def write(self, at: Address, spec: mujoco.MjSpec, value: float) -> None:
        """Set the value in a fresh spec."""
        body = at.part(spec)
        scale_inertia(body, value / body.mass)
        body.mass = value

    def fields(self, at: Address, model: mujoco.MjModel) -> Edits:
        """Compiled fields that carry the value."""
        row = at.row(model)
        inertia = FieldEdit("body_inertia", (row, slice(None)), relative=True)
        return (FieldEdit("body_mass", (row,), relative=True), inertia)


class InertiaScale(Attribute):
    """A factor on a body's inertia alone, so that every admissible pair of mass and factor is physically consistent."""

    def read(self, at: Address, spec: mujoco.MjSpec) -> float:
        """Nominal value in the spec."""
        del at, spec
        return 1.0

    def write(self, at: Address, spec: mujoco.MjSpec, value: float) -> None:
        """Set the value in a fresh spec."""
        scale_inertia(at.part(spec), value)

    def fields(self, at: Address, model: mujoco.MjModel) -> Edits:
        """Compiled fields that carry the value."""
        return (FieldEdit("body_inertia", (at.row(model), slice(None)), relative=True),)


class BodyTurn(Askew):
    """Of a body on its parent, about its own axes."""

    field = "body_quat"
    given = "quat"

    def read(self, at: Address, spec: mujoco.MjSpec) -> float:
        """Nominal value in the spec."""
        if at.part(spec).alt.type != mujoco.mjtOrientation.mjORIENTATION_QUAT:
            raise ModelError(f"Target {at}: give the orientation of body {at.element!r} as quat, not as euler or axes.")
        return 0.0


def _with_inertial(at: Address, spec: mujoco.MjSpec) -> Element:
    body = at.part(spec)
    if not body.explicitinertial:
        raise ModelError(f"Target {at}: body {at.element!r} needs an explicit <inertial> to vary its inertia.")
    return body


def scale_inertia(body: Element, factor: float) -> None:
    """Multiply a body's inertia in whichever form it stands.

    Of a sheet, A + B = C, rounding does not take A + B below C, which MuJoCo refuses.
    """
    if np.isfinite(body.fullinertia[0]):
        body.fullinertia = np.asarray(body.fullinertia) * factor
    else:
        small, middle, large = np.argsort(body.inertia)
        moments = np.asarray(body.inertia) * factor
        others = moments[small] + moments[middle]
        if moments[large] - others < _ROUNDING * others:
            moments[large] = min(moments[large], others)
        body.inertia = moments
