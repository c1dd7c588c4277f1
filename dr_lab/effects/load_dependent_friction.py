"""Friction of a gear that grows with the torque it carries."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.dry_friction import DryFrictionEffect
from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_drive import passive
from dr_lab.effects.joint_effect import driven
from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.law import Influence, Law, Moment
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class LoadDependentFriction(DryFrictionEffect, ForceLaw):
    """Dry friction between loaded teeth: proportional to what the motor and the outside press onto the gear.

    |tau| ≤ K |tau_m − tau_e|, against the motion: tau_m the motors' torque at the joint, tau_e the outside's, which is
    that of gravity, centrifugal and Coriolis forces. Actuators without a command are no motors, but for their cogging:
    other effects write frictions, offsets and springs so. A motor that holds a weight presses with twice its torque.
    Written into MuJoCo's ``frictionloss`` before every step, made hard by `DryFriction`.

    Parameters (nominal = absent): share K ≥ 0 [1].
    Limits: hinge and slide joints with an actuator; tau_m and tau_e are those of the step before, inertia and contact
    forces of the outside are left out.
    Source: Duclusaud, Passault, Padois and Ly, Extended friction models for the physics simulation of servo actuators,
    ICRA 2025 (K_l in the models M3 and M4).

    Attributes:
        constraint: how hard the friction constraint is.
        most: largest K.
    """

    most: float

    name: ClassVar[str] = "load_dependent_friction"
    family: ClassVar[str] = "friction"
    law: ClassVar[str] = "|tau| <= K |tau_m - tau_e|"
    fingerprint: ClassVar[str] = "dry friction that is large under load and gone without; lifting and lowering differ"
    confused_with: ClassVar[tuple[str, ...]] = ("coulomb_friction", "torque_scale")
    lacks: ClassVar[str] = "the friction loss of the joint that follows its load from step to step"

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the hinge and slide joints that an actuator drives."""
        return tuple(joint for joint in super().sites(model) if driven(model, joint))

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The share of the load."""
        del model, site, scales
        return (Parameter("share", "1", 0.0, 0.0, self.most),)

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The friction loss of each step."""
        joint = models[0].joint(site)
        return _Loaded(int(joint.dofadr[0]), values["share"], passive(models[0], joint.id))


@dataclass(frozen=True)
class _Loaded(Law):
    """Friction loss in proportion to the load of a degree of freedom.

    Attributes:
        dof: the degree of freedom.
        share: of the load, shape (n,).
        passive: what a unit of each actuator's output gives it where that is no motor's, shape (nout,).
    """

    dof: int
    share: Array
    passive: Array

    def act(self, moment: Moment, influence: Influence) -> None:
        motors = moment.actuation[:, self.dof] - moment.outputs @ self.passive
        influence.friction[:, self.dof] += self.share * np.abs(motors + moment.bias[:, self.dof])

    def replay_history(self, moment: Moment, influence: Influence) -> None:
        """Nothing: the load of then is unknown."""
