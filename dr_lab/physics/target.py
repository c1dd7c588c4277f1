"""Where a simulation parameter sits: ``kind.element.attribute[index]`` in a spec and in a compiled model."""

import re
from collections.abc import Mapping

import mujoco

from dr_lab.errors import ModelError, UnknownNameError
from dr_lab.physics.actuator_attributes import ForceLimit, ForceRange, ServoGain, TimeConstant
from dr_lab.physics.address import Address
from dr_lab.physics.attribute import Angle, Attribute, Edits, Entry, JointTurn, OptionEntry, position
from dr_lab.physics.body_attributes import BodyMass, BodyPlace, BodyTurn, InertialEntry, InertiaScale

_PATTERN = re.compile(r"^(?P<kind>\w+)\.(?:(?P<element>.+)\.)?(?P<attribute>\w+?)(?:\[(?P<index>\d+)\])?$")

# Sizes, densities and shapes' masses have no field: they change derived inertia, and the model is compiled anew.
_ATTRIBUTES: Mapping[str, Mapping[str, Attribute]] = {
    "body": {
        "mass": BodyMass(),
        "inertia": InertialEntry(3, "body_inertia"),
        "inertia_scale": InertiaScale(),
        "ipos": InertialEntry(3, "body_ipos"),
        "pos": BodyPlace(3, "body_pos"),
        "turn": BodyTurn(),
    },
    "joint": {
        "damping": Entry(1, "dof_damping", Address.dofs),
        "frictionloss": Entry(1, "dof_frictionloss", Address.dofs),
        "armature": Entry(1, "dof_armature", Address.dofs),
        "stiffness": Entry(1, "jnt_stiffness"),
        "springref": Angle(1, "qpos_spring", position),
        "ref": Angle(1, "qpos0", position),
        "turn": JointTurn(),
        "solref_limit": Entry(2, "jnt_solref"),
        "solimp_limit": Entry(5, "jnt_solimp"),
        "solref_friction": Entry(2, "dof_solref", Address.dofs),
        "solimp_friction": Entry(5, "dof_solimp", Address.dofs),
    },
    "geom": {
        "size": Entry(3),
        "friction": Entry(3, "geom_friction"),
        "density": Entry(),
        "mass": Entry(),
        "solref": Entry(2, "geom_solref"),
        "solimp": Entry(5, "geom_solimp"),
    },
    "actuator": {
        "gear": Entry(6, "actuator_gear"),
        "gainprm": Entry(10, "actuator_gainprm"),
        "biasprm": Entry(10, "actuator_biasprm"),
        "dynprm": Entry(10, "actuator_dynprm"),
        "time_constant": TimeConstant(),
        "force_limit": ForceLimit(),
        "forcerange": ForceRange(2, "actuator_forcerange"),
        "kp": ServoGain(),
        "kv": ServoGain(),
    },
    "option": {
        "gravity": OptionEntry(3, "opt.gravity"),
        "density": OptionEntry(1, "opt.density"),
        "viscosity": OptionEntry(1, "opt.viscosity"),
        "wind": OptionEntry(3, "opt.wind"),
    },
}


class Target(Address):
    """Parsed address of one scalar of the physics.

    ``body.<b>.mass`` scales the body's inertia along (same shape, other density); ``body.<b>.inertia_scale`` scales
    inertia alone, so every admissible pair is physically consistent. ``body.<b>.inertia`` are its principal moments,
    where the file gives them as ``diaginertia``. ``body.<b>.turn`` and ``joint.<j>.turn`` are angles by which a body on
    its parent, or a joint's axis, is off. ``actuator.<a>.force_limit`` is F of a symmetric ``forcerange`` ±F;
    ``actuator.<a>.kp`` and ``kv`` are the gains of a position servo, ``time_constant`` that of its activation.
    """

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
        index, entries = int(match["index"] or 0), _ATTRIBUTES[kind][attribute].entries
        if index >= entries:
            raise ModelError(f"Target {text!r}: index {index} is out of range (0…{entries - 1}).")
        return cls(kind, match["element"] or "", attribute, index)

    def read(self, spec: mujoco.MjSpec) -> float:
        """Nominal value in the spec.

        Raises:
            ModelError: the element is not of the sort that has it: a body's mass where the body has no <inertial>, its
                principal moments where it has a full inertia, a servo's gain where the actuator is none, and so on.
            UnknownNameError: the element is not in the model.
        """
        return self._attribute.read(self, spec)

    def write(self, spec: mujoco.MjSpec, value: float) -> None:
        """Set the value in a fresh spec (the caller's copy).

        Raises:
            UnknownNameError: the element is not in the model.
        """
        self._attribute.write(self, spec, value)

    def fields(self, model: mujoco.MjModel) -> Edits:
        """Compiled fields that carry the value, empty where the model must be recompiled (sizes, densities)."""
        return self._attribute.fields(self, model)

    @property
    def _attribute(self) -> Attribute:
        return _ATTRIBUTES[self.kind][self.attribute]
