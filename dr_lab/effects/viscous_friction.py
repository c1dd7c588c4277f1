"""Friction proportional to speed."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect, joint_of, slides
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class ViscousFriction(JointEffect, SpecEdit):
    """Lubricant, bearing seals and eddy currents: a force against the motion that grows with speed.

    tau(v) = −c v, added to the joint's own linear damping.

    Parameters (nominal = absent): coefficient c ≥ 0 [N·m·s/rad, slide: N·s/m].
    Limits: hinge and slide joints without ``springdamper``.
    Source: Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994), section 2; MuJoCo joint/damping.

    Attributes:
        factor: largest c, in units of the joint's torque/speed in the logs.
        least: smallest upper bound of c, for joints that hardly move [N·m·s/rad or N·s/m].
    """

    factor: float
    least: float

    name: ClassVar[str] = "viscous_friction"
    family: ClassVar[str] = "friction"
    law: ClassVar[str] = "tau = -c v"
    fingerprint: ClassVar[str] = "force residual proportional to velocity; swings decay exponentially, too slowly"
    confused_with: ClassVar[tuple[str, ...]] = ("quadratic_drag", "friction_drift", "actuator_delay", "torque_scale")

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The coefficient."""
        speed = scales.speed.get(site, 0.0)
        high = self.factor * scales.torque.get(site, 0.0) / speed if speed else 0.0
        unit = "N·s/m" if slides(model, site) else "N·m·s/rad"
        return (Parameter("coefficient", unit, 0.0, 0.0, max(high, self.least)),)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Add the coefficient to the linear term of the joint's damping."""
        joint_of(spec, site).damping[0] += values["coefficient"]
