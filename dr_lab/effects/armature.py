"""Inertia of a rotor that turns with a joint."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect, joint_of, slides
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class Armature(JointEffect, SpecEdit):
    """A motor's rotor and gears: inertia of the joint itself, without weight and without coupling to other joints.

    tau = −J q̈, added to the joint's own armature; a rotor behind a gear of ratio N counts N² times.

    Parameters (nominal = absent): inertia J ≥ 0 [kg·m², slide: kg].
    Limits: hinge and slide joints; the same as link inertia where one joint carries the link alone.
    Source: MuJoCo joint/armature.

    Attributes:
        factor: largest J, in units of the inertia that the joint has in the model's initial position.
        start: J of the fit that starts away from absent, share of its upper bound.
    """

    factor: float
    start: float

    name: ClassVar[str] = "armature"
    family: ClassVar[str] = "inertia"
    law: ClassVar[str] = "tau = -J q''"
    fingerprint: ClassVar[str] = "force residual proportional to acceleration; the joint answers too slowly"
    confused_with: ClassVar[tuple[str, ...]] = ("payload", "torque_scale", "joint_elasticity")

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The inertia."""
        del scales
        high = self.factor * float(model.dof_M0[model.joint(site).dofadr[0]])
        return (Parameter("inertia", "kg" if slides(model, site) else "kg·m²", 0.0, 0.0, high),)

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """An inertia from which a linear step sees rotors that are far larger than what the model has."""
        (inertia,) = parameters
        return ({"inertia": self.start * inertia.high},)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Add the inertia to the joint's armature."""
        joint_of(spec, site).armature += values["inertia"]
