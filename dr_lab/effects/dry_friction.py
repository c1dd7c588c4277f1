"""Dry friction as MuJoCo's friction-loss constraint, hard enough for measurements."""

from dataclasses import dataclass
from typing import Any

import mujoco

from dr_lab.effects.joint_effect import JointEffect, joint_of
from dr_lab.physics.effect_parts import SpecPreparation


@dataclass(frozen=True)
class Constraint:
    """A friction constraint whose speed at rest decays as v' = (1 − d) a₀ − d b v.

    Attributes:
        damping: d b in 1/s, as MuJoCo's direct format of solreffriction has it.
        impedance: d, within (0, 1).
    """

    damping: float
    impedance: float

    def put(self, joint: Any) -> None:  # noqa: ANN401 (MjsJoint)
        """Give it to a joint."""
        # negative: stiffness and damping themselves; a friction constraint has no position, so no stiffness acts
        joint.solref_friction = [-((self.damping / 2) ** 2), -self.damping]
        joint.solimp_friction[:2] = self.impedance

    def softened(self, share: float, soft: "Constraint") -> "Constraint":
        """The constraint whose 1/(d b) and 1 − d lie at a share of the way to those of a soft one."""
        damping = 1 / ((1 - share) / self.damping + share / soft.damping)
        return Constraint(damping, self.impedance + share * (soft.impedance - self.impedance))


@dataclass(frozen=True)
class DryFriction:
    """How hard the friction-loss constraint of a joint is.

    The constraint applies −sign(v)·loss while sliding; held at rest it lets the speed decay as v' = (1−d) a₀ − d b v,
    a₀ being the acceleration without friction. MuJoCo's defaults (d = 0.9 … 0.95, b = 105/s) creep at
    v = (1−d) a₀/(d b), which costs 1 mrad in 0.3 s. Here d is close to 1 and b is as high as the integrator allows:

    1. With first-order integrators b·timestep = 1 would stop a joint dead within a step, and the start velocity of a
       window would lose its influence. So b is lower, and a joint keeps a third of its speed.
    2. With RK4 a joint keeps at least 27 % (near b·timestep = 1.6); from 2.8 on the constraint is unstable.

    Source: MuJoCo 4.0, computation chapter ("Friction loss") and modeling chapter (solver parameters).

    Attributes:
        impedance: d, within (0, 1).
        rate_first_order: b·timestep for Euler, implicit and implicitfast.
        rate_rk4: b·timestep for RK4.
    """

    impedance: float
    rate_first_order: float
    rate_rk4: float

    def harden(self, spec: mujoco.MjSpec, joint: Any) -> None:  # noqa: ANN401 (MjsJoint)
        """Make the joint's constraint this hard.

        A joint that has friction loss of its own keeps the constraint settings that its author chose: otherwise
        an absent effect would not be the same physics.
        """
        if joint.frictionloss == 0:
            self.hardest(spec).put(joint)

    def hardest(self, spec: mujoco.MjSpec) -> Constraint:
        """The hardest constraint that a model allows."""
        rk4 = spec.option.integrator == mujoco.mjtIntegrator.mjINT_RK4
        return Constraint((self.rate_rk4 if rk4 else self.rate_first_order) / spec.option.timestep, self.impedance)


@dataclass(frozen=True)
class DryFrictionEffect(JointEffect, SpecPreparation):
    """An effect whose force is the friction-loss constraint of its joint.

    Attributes:
        constraint: how hard the friction constraint is.
    """

    constraint: DryFriction

    def prepare(self, spec: mujoco.MjSpec, site: str) -> None:
        """Make the friction constraint hard where the model has none, whatever a parameter makes of its size."""
        self.constraint.harden(spec, joint_of(spec, site))
