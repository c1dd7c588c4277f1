"""What may vary of an actuator beyond the numbers that stand in the spec as they are."""

from collections.abc import Mapping

import mujoco

from dr_lab.errors import ModelError
from dr_lab.physics.address import Address, FieldEdit
from dr_lab.physics.attribute import Attribute, Edits, Element, Entry

# entries that a servo's gains share, force = kp setpoint - kp length - kv velocity
_SERVO = {"kp": (("actuator_gainprm", 0), ("actuator_biasprm", 1)), "kv": (("actuator_biasprm", 2),)}


class ForceLimit(Attribute):
    """F of a symmetric ``forcerange`` ±F."""

    def read(self, at: Address, spec: mujoco.MjSpec) -> float:
        """Nominal value in the spec."""
        low, high = _range(at.part(spec))
        if not (0.0 < high == -low):
            raise ModelError(
                f"Target {at}: actuator {at.element!r} has forcerange [{low:g}, {high:g}]; expected [-F, F] with "
                "F > 0. Set it in the MJCF."
            )
        return high

    def write(self, at: Address, spec: mujoco.MjSpec, value: float) -> None:
        """Set the value in a fresh spec."""
        at.part(spec).forcerange = [-value, value]

    def fields(self, at: Address, model: mujoco.MjModel) -> Edits:
        """Compiled fields that carry the value."""
        return (FieldEdit("actuator_forcerange", (at.row(model), slice(None)), relative=True),)


class ForceRange(Entry):
    """An end of an actuator's ``forcerange``: [0] the lowest force, [1] the highest; see `require_ends_apart`."""

    def read(self, at: Address, spec: mujoco.MjSpec) -> float:
        """Nominal value in the spec."""
        low, high = _range(at.part(spec))
        if not low < high or at.part(spec).forcelimited == mujoco.mjtLimited.mjLIMITED_FALSE:
            raise ModelError(
                f"Target {at}: the force of actuator {at.element!r} is not limited. Give it a forcerange in the MJCF."
            )
        return super().read(at, spec)


class ServoGain(Attribute):
    """``kp`` or ``kv`` of a position servo, force = kp (setpoint − length) − kv velocity."""

    def read(self, at: Address, spec: mujoco.MjSpec) -> float:
        """Nominal value in the spec."""
        element = at.part(spec)
        gain, (_, place, velocity) = float(element.gainprm[0]), (float(value) for value in element.biasprm[:3])
        if not (gain == -place > 0.0):
            raise ModelError(
                f"Target {at}: actuator {at.element!r} has gainprm[0] {gain:g} and biasprm[1] {place:g}; "
                "expected those of a position servo, kp > 0 and -kp. Take a <position> or <intvelocity> actuator."
            )
        return gain if at.attribute == "kp" else -velocity

    def write(self, at: Address, spec: mujoco.MjSpec, value: float) -> None:
        """Set the value in a fresh spec."""
        element = at.part(spec)
        if at.attribute == "kp":
            element.gainprm[0], element.biasprm[1] = value, -value
        else:
            element.biasprm[2] = -value

    def fields(self, at: Address, model: mujoco.MjModel) -> Edits:
        """Compiled fields that carry the value."""
        row = at.row(model)
        return tuple(FieldEdit(field, (row, entry), relative=True) for field, entry in _SERVO[at.attribute])


class TimeConstant(Entry):
    """The time constant in s of an actuator's first-order activation, ``dynprm[0]``."""

    def read(self, at: Address, spec: mujoco.MjSpec) -> float:
        """Nominal value in the spec."""
        element = at.part(spec)
        if element.dyntype not in (mujoco.mjtDyn.mjDYN_FILTER, mujoco.mjtDyn.mjDYN_FILTEREXACT):
            raise ModelError(
                f"Target {at}: actuator {at.element!r} has dyntype {mujoco.mjtDyn(element.dyntype).name[6:].lower()}, "
                "which has no time constant. Give it timeconst (a <position>) or dyntype filterexact in the MJCF."
            )
        return float(element.dynprm[0])

    def write(self, at: Address, spec: mujoco.MjSpec, value: float) -> None:
        """Set the value in a fresh spec."""
        at.part(spec).dynprm[0] = value

    def fields(self, at: Address, model: mujoco.MjModel) -> Edits:
        """Compiled fields that carry the value."""
        return (FieldEdit("actuator_dynprm", (at.row(model), 0), relative=False),)


def require_ends_apart(spec: mujoco.MjSpec, bounds: Mapping[Address, tuple[float, float]]) -> None:
    """Check that the lowest force of an actuator stays below its highest one, whatever is fitted or drawn.

    Args:
        spec: what an end that is not free is read from.
        bounds: low and high of free scalars by where they sit; only ends of a ``forcerange`` are looked at.

    Raises:
        ModelError: the bounds let the ends meet or cross.
    """
    ends = {(at.element, at.index): bound for at, bound in bounds.items() if at.attribute == "forcerange"}
    for name in dict.fromkeys(name for name, _ in ends):
        low, high = _range(spec.actuator(name))
        most, least = ends.get((name, 0), (low, low))[1], ends.get((name, 1), (high, high))[0]
        if most >= least:
            raise ModelError(
                f"actuator.{name}.forcerange[0] may be as high as {most:g} and actuator.{name}.forcerange[1] as low as "
                f"{least:g}, so that the ends would cross. Lower the high of the first, or raise the low of the second."
            )


def _range(element: Element) -> tuple[float, float]:
    low, high = (float(value) for value in element.forcerange)
    return low, high
