"""A constant force at a joint."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect, add_passive_force, joint_of, slides
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class ConstantOffset(JointEffect, SpecEdit):
    """An amplifier's offset, a counterweight or a constant-force spring.

    tau = tau_0, whatever the state: an actuator without command whose bias is tau_0. It adds an actuator to the model
    at every value (called ``constant_offset@<joint>``), but no command and no state.

    Parameters (nominal = absent): torque tau_0 [N·m, slide: N].
    Limits: hinge and slide joints.
    Source: Gautier and Khalil, Modeling, Identification and Control of Robots (2002), chapter 12 (offset of the
    friction model); MuJoCo actuator/general/biastype "affine".

    Attributes:
        factor: largest |tau_0|, in units of the joint's torque in the logs.
        least: smallest bound of |tau_0|, for joints that hardly move [N·m or N].
    """

    factor: float
    least: float

    name: ClassVar[str] = "constant_offset"
    family: ClassVar[str] = "actuator"
    law: ClassVar[str] = "tau = tau_0"
    fingerprint: ClassVar[str] = "force residual with a mean; the joint drifts or rests off centre"
    confused_with: ClassVar[tuple[str, ...]] = ("spring", "base_tilt")

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The torque."""
        bound = max(self.factor * scales.torque.get(site, 0.0), self.least)
        return (Parameter("torque", "N" if slides(model, site) else "N·m", 0.0, -bound, bound),)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Add the command-free actuator."""
        joint = joint_of(spec, site)
        add_passive_force(spec, joint.name, f"{self.name}@{site}").biasprm[0] = values["torque"]
