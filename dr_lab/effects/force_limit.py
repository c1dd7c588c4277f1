"""A controlled drive whose force ends at a limit."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.actuator_effect import ActuatorEffect, actuator_of
from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_force import acts_on, moves_joint
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter

_AFFINE = int(mujoco.mjtBias.mjBIAS_AFFINE)


@dataclass(frozen=True)
class ForceLimit(ActuatorEffect, SpecEdit):
    """The largest force of a servo: its current limit, its supply, or a clutch.

    F → clip(F, −1/i, 1/i), within the actuator's own force range. A servo that is far from its target pulls no harder
    than that, so it moves at a speed that its damping sets. The parameter is the inverse of the limit, so that absent
    is a finite value. Of a motor whose force is gain times command `saturation` is the same.

    Parameters (nominal = absent): inverse_limit i ≥ 0 [1/(N·m), 1/N] of the actuator's own force.
    Limits: position and velocity servos at a hinge or slide; symmetric. A limit above the file's own
    does not act: let `actuator.<name>.force_limit` be free for that. No slope at absent: fits start at several limits.
    Source: MuJoCo 4.0, XML reference, actuator/general/forcerange.

    Attributes:
        deepest: smallest limit, in units of the RMS force that the joint's motion needs.
        least: smallest force that is believed [N·m or N].
        start_limits: limits of the fits that start away from absent, in the same units.
    """

    deepest: float
    least: float
    start_limits: tuple[float, ...]

    name: ClassVar[str] = "force_limit"
    family: ClassVar[str] = "actuator"
    law: ClassVar[str] = "F -> clip(F, -limit, limit)"
    fingerprint: ClassVar[str] = "residual only while the target is far: the joint follows it at a limited speed"
    confused_with: ClassVar[tuple[str, ...]] = ("rate_limit", "gain_error", "torque_scale", "saturation")

    def acts_at(self, model: mujoco.MjModel, row: int) -> bool:
        """At a joint, where the force depends on its motion, too."""
        return moves_joint(model, row) and int(model.actuator_biastype[row]) == _AFFINE

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The inverse limit."""
        joint, gear, slide = acts_on(model, site)
        needed = max(scales.torque.get(joint, 0.0) / max(gear, self.least), self.least)
        return (Parameter("inverse_limit", "1/N" if slide else "1/(N·m)", 0.0, 0.0, 1.0 / (self.deepest * needed)),)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Narrow the force range."""
        actuator = actuator_of(spec, site)
        if values["inverse_limit"] == 0:
            return
        limit = 1.0 / values["inverse_limit"]
        low, high = actuator.forcerange
        bounded = actuator.forcelimited != mujoco.mjtLimited.mjLIMITED_FALSE and low < high
        inside = [end if bounded and abs(end) < limit else bound for end, bound in ((low, -limit), (high, limit))]
        actuator.forcerange = inside
        actuator.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Limits about the force that the motion needs."""
        (inverse,) = parameters
        return tuple({"inverse_limit": inverse.high * self.deepest / share} for share in self.start_limits)
