"""A linear spring between a joint's two bodies, such as a cable's pull."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
from numpy.polynomial import Polynomial

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect, require_place, slides
from dr_lab.effects.joint_spring import add_spring
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter

Start = Mapping[str, float]


@dataclass(frozen=True)
class Spring(JointEffect, SpecEdit):
    """A cable, hose or spring that pulls the joint to a rest position.

    tau(q) = −k (q − q_r), beside the joint's own spring (`add_spring`).

    Parameters (nominal = absent): stiffness k ≥ 0 [N·m/rad, slide: N/m]; reference q_r [rad, slide: m], which acts
    only where k > 0 (fits start away from absent).
    Limits: hinge and slide joints without ``springdamper`` or ``springyield``; tendons whose rest length MuJoCo takes
    from the springs' references move with it.
    Source: Hooke's law.

    Attributes:
        factor: largest k, in units of the joint's torque/range in the logs.
        least: smallest upper bound of k, for joints that hardly move [N·m/rad or N/m].
        reach: bounds of q_r about the model's zero position, in units of the joint's range in the logs.
        least_reach: smallest bound of q_r [rad or m].
        start_stiffness: k of the fits that start away from absent, share of its upper bound.
        start_references: q_r of these fits, shares of its upper bound.
    """

    factor: float
    least: float
    reach: float
    least_reach: float
    start_stiffness: float
    start_references: tuple[float, ...]

    name: ClassVar[str] = "spring"
    family: ClassVar[str] = "transmission"
    law: ClassVar[str] = "tau = -k (q - q_r)"
    fingerprint: ClassVar[str] = "force residual proportional to position; wrong frequency and centre of swings"
    confused_with: ClassVar[tuple[str, ...]] = ("constant_offset", "base_tilt", "payload")
    argument: ClassVar[str] = "position"
    shapes: ClassVar[tuple[str, ...]] = ("reference",)
    outlying: ClassVar[tuple[str, ...]] = ("reference",)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The stiffness and the rest position."""
        require_place(model, site, scales)
        span = scales.position.get(site, 0.0)
        high = self.factor * scales.torque.get(site, 0.0) / span if span else 0.0
        zero = float(model.qpos0[model.joint(site).qposadr[0]])
        reach = max(self.reach * span, self.least_reach)
        slide = slides(model, site)
        return (
            Parameter("stiffness", "N/m" if slide else "N·m/rad", 0.0, 0.0, max(high, self.least)),
            Parameter("reference", "m" if slide else "rad", zero, zero - reach, zero + reach),
        )

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Combine the spring with the joint's own."""
        stiffness, reference = values["stiffness"], values["reference"]
        add_spring(spec, site, Polynomial([-stiffness * reference, stiffness]), reference)

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Start, ...]:
        """A light spring whose rest position lies below or above the joint's zero."""
        stiffness, reference = parameters
        half = reference.span / 2
        return tuple(
            {"stiffness": self.start_stiffness * stiffness.high, "reference": reference.nominal + share * half}
            for share in self.start_references
        )
