"""A joint's spring whose stiffness grows, or falls, with its displacement."""

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


@dataclass(frozen=True)
class HardeningSpring(JointEffect, SpecEdit):
    """A flexure, rubber mount, conical or stretched spring, which pulls more than in proportion to its displacement.

    tau(q) = −c (q − q_r)³, beside the joint's own spring (`add_spring`). It is the next term of any force that is odd
    in the displacement, as of Duffing's oscillator. A spring that softens has c < 0.

    Parameters (nominal = absent): cubic c [N·m/rad³, slide: N/m³], of either sign; reference q_r [rad, slide: m], which
    acts only where c is not 0, and is where the model's own spring rests at first (fits start away from absent).
    Limits: hinge and slide joints without ``springdamper`` or ``springyield``; the linear term is `spring`.
    Source: Kovacic and Brennan, The Duffing Equation, Wiley 2011, chapter 2.

    Attributes:
        factor: largest size of c, in units of the joint's torque over half its range, cubed, in the logs.
        least: its smallest upper bound, for joints that hardly move [N·m/rad³ or N/m³].
        reach: bounds of q_r about where it is at first, in units of the joint's range in the logs.
        least_reach: smallest bound of q_r [rad or m].
        start: size of c of the fits that start away from absent, share of its upper bound.
    """

    factor: float
    least: float
    reach: float
    least_reach: float
    start: float

    name: ClassVar[str] = "hardening_spring"
    family: ClassVar[str] = "transmission"
    law: ClassVar[str] = "tau = -c (q - q_r)^3"
    fingerprint: ClassVar[str] = "force residual cubic in position; wide swings are faster than narrow ones"
    confused_with: ClassVar[tuple[str, ...]] = ("spring", "end_stop", "cogging")
    argument: ClassVar[str] = "position"
    shapes: ClassVar[tuple[str, ...]] = ("reference",)
    outlying: ClassVar[tuple[str, ...]] = ("reference",)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The cubic coefficient and the rest position."""
        require_place(model, site, scales)
        span, slide = scales.position.get(site, 0.0), slides(model, site)
        high = self.factor * scales.torque.get(site, 0.0) / (span / 2) ** 3 if span else 0.0
        high, reach = max(high, self.least), max(self.reach * span, self.least_reach)
        rest = float(model.qpos_spring[model.joint(site).qposadr[0]])
        return (
            Parameter("cubic", "N/m³" if slide else "N·m/rad³", 0.0, -high, high),
            Parameter("reference", "m" if slide else "rad", rest, rest - reach, rest + reach),
        )

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Combine the spring with the joint's own."""
        cubic, reference = values["cubic"], values["reference"]
        add_spring(spec, site, cubic * Polynomial([-reference, 1.0]) ** 3, reference)

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """A spring that hardens, and rests where the model's own does; one that softens is found from absent."""
        cubic, reference = parameters
        return ({"cubic": self.start * cubic.high, "reference": reference.nominal},)
