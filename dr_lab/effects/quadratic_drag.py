"""Drag that grows with the square of speed."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect, joint_of, slides
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class QuadraticDrag(JointEffect, SpecEdit):
    """Air or fluid that a link pushes aside.

    tau(v) = −c v |v|, added to the second coefficient of the joint's damping polynomial.

    Parameters (nominal = absent): coefficient c ≥ 0 [N·m·s²/rad², slide: N·s²/m²].
    Limits: hinge and slide joints without ``springdamper``; the drag of one joint alone.
    Source: Newton's drag law; MuJoCo joint/damping and computation chapter ("Polynomial forces").

    Attributes:
        factor: largest c, in units of the joint's torque/speed² in the logs.
        least: smallest upper bound of c, for joints that hardly move [N·m·s²/rad² or N·s²/m²].
    """

    factor: float
    least: float

    name: ClassVar[str] = "quadratic_drag"
    family: ClassVar[str] = "friction"
    law: ClassVar[str] = "tau = -c v |v|"
    fingerprint: ClassVar[str] = "force residual grows with the square of velocity; only fast motion decays too slowly"
    confused_with: ClassVar[tuple[str, ...]] = ("viscous_friction",)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The coefficient."""
        speed = scales.speed.get(site, 0.0)
        high = self.factor * scales.torque.get(site, 0.0) / speed**2 if speed else 0.0
        unit = "N·s²/m²" if slides(model, site) else "N·m·s²/rad²"
        return (Parameter("coefficient", unit, 0.0, 0.0, max(high, self.least)),)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Add the coefficient to the quadratic term of the joint's damping."""
        joint_of(spec, site).damping[1] += values["coefficient"]
