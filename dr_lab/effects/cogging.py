"""A motor's torque that depends on where its rotor stands."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import atan2, hypot
from typing import ClassVar

import mujoco

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect, add_passive_force, joint_of, require_place, slides
from dr_lab.effects.periodic import PERIODS, Periodic, a_radian_a_step, half_a_period
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class Cogging(JointEffect, Periodic, SpecEdit):
    """The pull of permanent magnets towards the iron teeth of the stator, or a gear or screw that runs out of true.

    tau(q) = A sin(n q) + B cos(n q) = C sin(n q + phi), C = √(A² + B²), tan(phi) = B/A: MuJoCo's ``dcmotor`` without
    input and current, of which only the cogging torque is left (``cogging@<joint>``).

    Parameters (nominal = absent): sine A, cosine B [N·m, slide: N]; periods n [1/turn, slide: rad/m], which acts only
    where A or B is not zero and is none where the user gives it.
    Limits: hinge and slide joints; one harmonic per effect; steps of time that resolve n q̇. n cannot be told where the
    joint's way in the logs is less than half a period.
    Source: Hanselman, Brushless Permanent Magnet Motor Design (2003), chapter 9 (n is the least common multiple of
    slots and poles); MuJoCo 4.0, XML reference, actuator/dcmotor/cogging.

    Attributes:
        factor: largest |A| and |B|, in units of the joint's torque in the logs.
        least: their smallest bound, for joints that hardly move [N·m, slide: N].
    """

    factor: float
    least: float

    name: ClassVar[str] = "cogging"
    family: ClassVar[str] = "actuator"
    law: ClassVar[str] = "tau = A sin(n q) + B cos(n q)"
    fingerprint: ClassVar[str] = "force residual that repeats n times in a turn, at any speed; uneven slow motion"
    confused_with: ClassVar[tuple[str, ...]] = ("spring", "coulomb_friction")
    argument: ClassVar[str] = "position"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The amplitudes of the two phases and the number of periods."""
        require_place(model, site, scales)
        bound = max(self.factor * scales.torque.get(site, 0.0), self.least)
        unit = "N" if slides(model, site) else "N·m"
        phases = (Parameter(phase, unit, 0.0, -bound, bound) for phase in ("sine", "cosine"))
        few, many = half_a_period(site, scales), a_radian_a_step(model, site, scales)
        return (*phases, *self.number(model, site, few, many))

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Add the motor of which only the cogging is left."""
        sine, cosine, periods = values["sine"], values["cosine"], values.get(PERIODS, self.periods)
        torque = (hypot(sine, cosine), periods, atan2(cosine, sine))
        motor = add_passive_force(spec, joint_of(spec, site).name, f"{self.name}@{site}")
        motor.set_to_dcmotor((0.0, 0.0), 1.0, cogging=torque, ctrlspec=int(mujoco.mjtCtrlInput.mjINPUT_NONE))
