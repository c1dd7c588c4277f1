"""Dry friction that creeps at rest, as MuJoCo's own does."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.dry_friction import Constraint, DryFrictionEffect
from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import joint_of, slides
from dr_lab.effects.special_case import SpecialCase
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class SoftFriction(DryFrictionEffect, SpecEdit):
    """Dry friction by a soft constraint, which a machine has that is itself simulated: MuJoCo's ``frictionloss``.

    tau = −tau_c sign(v) while sliding. At rest the speed decays as v' = (1 − d) a₀ − d b v, a₀ being the acceleration
    without friction, so that the joint creeps at (1 − d) a₀/(d b). With softness s, 1 − d and 1/(d b) lie at the share
    s of the way from the hard constraint of Coulomb friction (`DryFriction`) to MuJoCo's defaults: towards s = 0 it is
    Coulomb friction, at s = 1 what ``frictionloss`` alone gives. A real joint creeps by other laws: see
    `PreslidingFriction`.

    Parameters (nominal = absent): torque tau_c ≥ 0 [N·m, slide: N]; softness s > 0 [1], which acts only where
    tau_c > 0 (fits start away from absent).
    Limits: hinge and slide joints without friction loss of their own, whose constraint stays as its author chose it.
    Beside other dry friction of the joint the constraint is as soft as the mean over their torques.
    Source: MuJoCo 4.0, computation chapter ("Friction loss") and modeling chapter (solver parameters).

    Attributes:
        factor: largest tau_c, in units of the joint's torque in the logs.
        least: smallest upper bound of tau_c, for joints that hardly move [N·m or N].
        default: MuJoCo's own constraint.
        softnesses: smallest, nominal and largest s.
        start_torque: tau_c of the fit that starts away from absent, share of its upper bound.
    """

    factor: float
    least: float
    default: Constraint
    softnesses: tuple[float, float, float]
    start_torque: float

    name: ClassVar[str] = "soft_friction"
    family: ClassVar[str] = "friction"
    law: ClassVar[str] = "tau = -tau_c sign(v); at rest v' = (1-d) a0 - d b v, as MuJoCo's frictionloss"
    fingerprint: ClassVar[str] = "force residual jumps with the sign of velocity; creeps at rest as far as it is pushed"
    confused_with: ClassVar[tuple[str, ...]] = (
        "coulomb_friction",
        "smooth_friction",
        "presliding_friction",
        "viscous_friction",
    )
    holds: ClassVar[Mapping[str, SpecialCase]] = {"coulomb_friction": SpecialCase(("softness",), {"torque": "torque"})}
    shapes: ClassVar[tuple[str, ...]] = ("softness",)

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the joints without friction loss of their own."""
        return tuple(name for name in super().sites(model) if model.dof_frictionloss[model.joint(name).dofadr[0]] == 0)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The torque, and how soft the constraint is."""
        unit = "N" if slides(model, site) else "N·m"
        high = max(self.factor * scales.torque.get(site, 0.0), self.least)
        hardest, usual, softest = self.softnesses
        return (Parameter("torque", unit, 0.0, 0.0, high), Parameter("softness", "1", usual, hardest, softest))

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Add the torque to the joint's friction loss, and soften its constraint."""
        joint, torque = joint_of(spec, site), values["torque"]
        if torque <= 0:
            return
        joint.frictionloss += torque
        share = values["softness"] * torque / joint.frictionloss
        hard = Constraint(-float(joint.solref_friction[1]), float(joint.solimp_friction[0]))
        hard.softened(share, self.default).put(joint)

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Little friction, as soft as MuJoCo's."""
        torque, softness = parameters
        return ({"torque": self.start_torque * torque.high, "softness": softness.nominal},)
