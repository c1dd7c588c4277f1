"""A motor's torque that depends on where its rotor stands."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import atan2, hypot
from typing import ClassVar

import mujoco

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect, add_passive_force, joint_of, slides
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class Cogging(JointEffect, SpecEdit):
    """The pull of permanent magnets towards the iron teeth of the stator, or a gear that runs out of true.

    tau(q) = A sin(n q) + B cos(n q) = C sin(n q + phi), C = √(A² + B²), tan(phi) = B/A: MuJoCo's ``dcmotor`` without
    input and current, of which only the cogging torque is left (``cogging@<joint>``).

    Parameters (nominal = absent): sine A, cosine B [N·m]. The number of periods n is no parameter: the error as a
    function of n has a valley at every harmonic, so a fit would stay near the n at which it began.
    Limits: hinge joints; one harmonic per effect; steps of time that resolve n q̇.
    Source: Hanselman, Brushless Permanent Magnet Motor Design (2003), chapter 9 (n is the least common multiple of
    slots and poles); MuJoCo 4.0, XML reference, actuator/dcmotor/cogging.

    Attributes:
        periods: n, periods in a turn of the joint (of the rotor, times the gear ratio).
        factor: largest |A| and |B|, in units of the joint's torque in the logs.
        least: their smallest bound, for joints that hardly move [N·m].
    """

    periods: int
    factor: float
    least: float

    name: ClassVar[str] = "cogging"
    family: ClassVar[str] = "actuator"
    law: ClassVar[str] = "tau = A sin(n q) + B cos(n q)"
    fingerprint: ClassVar[str] = "force residual that repeats n times in a turn, at any speed; uneven slow motion"
    confused_with: ClassVar[tuple[str, ...]] = ("spring", "coulomb_friction")
    argument: ClassVar[str] = "position"

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the hinge joints."""
        return tuple(joint for joint in super().sites(model) if not slides(model, joint))

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The amplitudes of the two phases."""
        del model
        bound = max(self.factor * scales.torque.get(site, 0.0), self.least)
        return tuple(Parameter(phase, "N·m", 0.0, -bound, bound) for phase in ("sine", "cosine"))

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Add the motor of which only the cogging is left."""
        sine, cosine = values["sine"], values["cosine"]
        torque = (hypot(sine, cosine), float(self.periods), atan2(cosine, sine))
        motor = add_passive_force(spec, joint_of(spec, site).name, f"{self.name}@{site}")
        motor.set_to_dcmotor((0.0, 0.0), 1.0, cogging=torque, ctrlspec=int(mujoco.mjtCtrlInput.mjINPUT_NONE))
