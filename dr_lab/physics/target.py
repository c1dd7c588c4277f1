"""Where a simulation parameter sits: ``kind.element.attribute[index]`` in a spec and in a compiled model."""

import re
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from dr_lab.errors import ModelError, UnknownNameError

_PATTERN = re.compile(r"^(?P<kind>\w+)\.(?:(?P<element>.+)\.)?(?P<attribute>\w+?)(?:\[(?P<index>\d+)\])?$")

# attribute -> number of entries; polynomial damping and stiffness are addressed by their linear entry
_ATTRIBUTES: dict[str, dict[str, int]] = {
    "body": {"mass": 1, "inertia": 3, "inertia_scale": 1, "ipos": 3, "pos": 3},
    "joint": {"damping": 1, "frictionloss": 1, "armature": 1, "stiffness": 1, "springref": 1},
    "geom": {"size": 3, "friction": 3, "density": 1, "mass": 1},
    "actuator": {"gear": 6, "gainprm": 10, "force_limit": 1, "kp": 1, "kv": 1},
    "option": {"gravity": 3, "density": 1, "viscosity": 1, "wind": 3},
}

# compiled field written without recompiling; the others change sizes or derived inertia
_FIELDS = {
    ("body", "inertia"): "body_inertia",
    ("body", "ipos"): "body_ipos",
    ("body", "pos"): "body_pos",
    ("joint", "damping"): "dof_damping",
    ("joint", "frictionloss"): "dof_frictionloss",
    ("joint", "armature"): "dof_armature",
    ("joint", "stiffness"): "jnt_stiffness",
    ("joint", "springref"): "qpos_spring",
    ("geom", "friction"): "geom_friction",
    ("actuator", "gear"): "actuator_gear",
    ("actuator", "gainprm"): "actuator_gainprm",
    ("option", "gravity"): "opt.gravity",
    ("option", "density"): "opt.density",
    ("option", "viscosity"): "opt.viscosity",
    ("option", "wind"): "opt.wind",
}
# entries that a servo's gains share, force = kp setpoint - kp length - kv velocity
_SERVO = {"kp": (("actuator_gainprm", 0), ("actuator_biasprm", 1)), "kv": (("actuator_biasprm", 2),)}
_PER_DOF = {"dof_damping", "dof_frictionloss", "dof_armature"}


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
class Target:
    """Parsed address of one scalar of the physics.

    ``body.<b>.mass`` scales the body's inertia along (same shape, other density); ``body.<b>.inertia_scale`` scales
    inertia alone, so every admissible pair is physically consistent. ``body.<b>.inertia`` are its principal moments,
    where the file gives them as ``diaginertia``. ``actuator.<a>.force_limit`` is F of a symmetric ``forcerange`` ±F;
    ``actuator.<a>.kp`` and ``kv`` are the gains of a position servo.
    """

    kind: str
    element: str
    attribute: str
    index: int

    @classmethod
    def parse(cls, text: str) -> "Target":
        """Read ``kind.element.attribute[index]``, e.g. ``body.arm.mass`` or ``option.gravity[2]``.

        Raises:
            ModelError: the text has another form.
            UnknownNameError: kind or attribute do not exist; the message lists those that do.
        """
        match = _PATTERN.match(text)
        if match is None:
            raise ModelError(f"Target {text!r} is not of the form kind.element.attribute[index], e.g. body.arm.mass.")
        kind, attribute = match["kind"], match["attribute"]
        if kind not in _ATTRIBUTES:
            raise UnknownNameError("target kind", kind, _ATTRIBUTES, f"target {text!r}")
        if attribute not in _ATTRIBUTES[kind]:
            raise UnknownNameError("attribute", attribute, _ATTRIBUTES[kind], f"target {text!r}")
        index = int(match["index"] or 0)
        if index >= _ATTRIBUTES[kind][attribute]:
            raise ModelError(f"Target {text!r}: index {index} is out of range (0…{_ATTRIBUTES[kind][attribute] - 1}).")
        return cls(kind, match["element"] or "", attribute, index)

    def __str__(self) -> str:
        """The text form."""
        middle = f"{self.element}." if self.element else ""
        return f"{self.kind}.{middle}{self.attribute}[{self.index}]"

    def read(self, spec: mujoco.MjSpec) -> float:
        """Nominal value in the spec.

        Raises:
            ModelError: a body's mass is asked for but the body has no <inertial>, its principal moments but it has a
                full inertia, an actuator's force limit but its force is not limited symmetrically, or a servo's gain
                but it is none.
            UnknownNameError: the element is not in the model.
        """
        if self.attribute == "inertia_scale":
            return 1.0
        element = self._element(spec)
        if self.attribute == "force_limit":
            return self._force_limit(element)
        if self.attribute in _SERVO:
            return self._servo_gain(element)
        if self.kind == "body" and self.attribute in ("mass", "inertia", "ipos") and not element.explicitinertial:
            raise ModelError(f"Target {self}: body {self.element!r} needs an explicit <inertial> to vary its inertia.")
        if self.attribute == "inertia" and np.isfinite(element.fullinertia[0]):
            raise ModelError(
                f"Target {self}: body {self.element!r} has a fullinertia. Give it as diaginertia and quat."
            )
        value = np.atleast_1d(np.asarray(getattr(element, self.attribute), dtype=float))
        return float(value[self.index]) * self._unit(spec)

    def write(self, spec: mujoco.MjSpec, value: float) -> None:
        """Set the value in a fresh spec (the caller's copy).

        MuJoCo stores less of the mass matrix of a body whose centre of mass is its origin (``simple``), which no
        centre may then leave; a body whose centre is set is stored whole, at every value.

        Raises:
            UnknownNameError: the element is not in the model.
        """
        element = self._element(spec)
        if self.attribute == "inertia_scale":
            _scale_inertia(element, value)
        elif self.attribute == "force_limit":
            element.forcerange = [-value, value]
        elif self.attribute == "kp":
            element.gainprm[0], element.biasprm[1] = value, -value
        elif self.attribute == "kv":
            element.biasprm[2] = -value
        elif self.attribute == "mass" and self.kind == "body":
            _scale_inertia(element, value / element.mass)
            element.mass = value
        elif np.ndim(getattr(element, self.attribute)):
            getattr(element, self.attribute)[self.index] = value
        else:
            setattr(element, self.attribute, value / self._unit(spec))
        if self.attribute == "ipos":
            element.simple = False

    def fields(self, model: mujoco.MjModel) -> tuple[FieldEdit, ...]:
        """Compiled fields that carry the value, empty where the model must be recompiled (sizes, densities)."""
        if self.kind == "body" and self.attribute in ("mass", "inertia_scale"):
            row = model.body(self.element).id
            inertia = FieldEdit("body_inertia", (row, slice(None)), relative=True)
            mass = FieldEdit("body_mass", (row,), relative=True)
            return (mass, inertia) if self.attribute == "mass" else (inertia,)
        if self.attribute == "force_limit":
            row = model.actuator(self.element).id
            return (FieldEdit("actuator_forcerange", (row, slice(None)), relative=True),)
        if self.attribute in _SERVO:
            row = model.actuator(self.element).id
            return tuple(FieldEdit(field, (row, entry), relative=True) for field, entry in _SERVO[self.attribute])
        field = _FIELDS.get((self.kind, self.attribute))
        if field is None:
            return ()
        return (FieldEdit(field, self._row(model, field), relative=False),)

    def _row(self, model: mujoco.MjModel, field: str) -> tuple[int, ...]:
        if self.kind == "option":
            return (self.index,) if _ATTRIBUTES["option"][self.attribute] > 1 else ()
        row = getattr(model, self.kind)(self.element).id
        if field in _PER_DOF:
            return (int(model.jnt_dofadr[row]),)
        if field == "qpos_spring":
            return (int(model.jnt_qposadr[row]),)
        return (row, self.index) if _ATTRIBUTES[self.kind][self.attribute] > 1 else (row,)

    def _force_limit(self, actuator: Any) -> float:  # noqa: ANN401 (MjsActuator)
        low, high = (float(value) for value in actuator.forcerange)
        if not (0.0 < high == -low):
            raise ModelError(
                f"Target {self}: actuator {self.element!r} has forcerange [{low:g}, {high:g}]; expected [-F, F] with "
                "F > 0. Set it in the MJCF."
            )
        return high

    def _servo_gain(self, element: Any) -> float:  # noqa: ANN401 (MjsActuator)
        gain, (_, position, velocity) = float(element.gainprm[0]), (float(value) for value in element.biasprm[:3])
        if not (gain == -position > 0.0):
            raise ModelError(
                f"Target {self}: actuator {self.element!r} has gainprm[0] {gain:g} and biasprm[1] {position:g}; "
                "expected those of a position servo, kp > 0 and -kp. Take a <position> or <intvelocity> actuator."
            )
        return gain if self.attribute == "kp" else -velocity

    def _unit(self, spec: mujoco.MjSpec) -> float:
        """The spec's unit of the value in SI; where MJCF angles are degrees, a hinge's reference is one of them."""
        degrees = self.attribute == "springref" and spec.compiler.degree
        return np.pi / 180 if degrees and spec.joint(self.element).type != mujoco.mjtJoint.mjJNT_SLIDE else 1.0

    def _element(self, spec: mujoco.MjSpec) -> Any:  # noqa: ANN401 (MjSpec elements share no public base class)
        if self.kind == "option":
            return spec.option
        element = getattr(spec, self.kind)(self.element)
        if element is None:
            names = [e.name for e in _elements(spec, self.kind) if e.name]
            raise UnknownNameError(self.kind, self.element, names, f"model {spec.modelname!r}")
        return element


def _elements(spec: mujoco.MjSpec, kind: str) -> list[Any]:
    """All elements of a kind ("body", "joint", "geom", "actuator") in the spec."""
    return list({"body": spec.bodies, "joint": spec.joints, "geom": spec.geoms, "actuator": spec.actuators}[kind])


def _scale_inertia(body: Any, factor: float) -> None:  # noqa: ANN401 (MjsBody)
    if np.isfinite(body.fullinertia[0]):
        body.fullinertia = np.asarray(body.fullinertia) * factor
    else:
        body.inertia = np.asarray(body.inertia) * factor
