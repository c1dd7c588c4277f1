"""Dry friction as MuJoCo's friction-loss constraint, hard enough for measurements."""

from dataclasses import dataclass
from typing import Any

import mujoco

from dr_lab.effects.joint_effect import JointEffect, joint_of
from dr_lab.physics.effect_parts import SpecPreparation


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
            set_constraint(joint, self.damping(spec), self.impedance)

    def damping(self, spec: mujoco.MjSpec) -> float:
        """The rate b of a model's hardest constraint in 1/s."""
        rk4 = spec.option.integrator == mujoco.mjtIntegrator.mjINT_RK4
        return (self.rate_rk4 if rk4 else self.rate_first_order) / spec.option.timestep


def set_constraint(joint: Any, damping: float, impedance: float) -> None:  # noqa: ANN401 (MjsJoint)
    """Give a joint's friction constraint its rate b in 1/s and its impedance d."""
    # negative: stiffness and damping themselves; a friction constraint has no position, so no stiffness acts
    joint.solref_friction = [-((damping / 2) ** 2), -damping]
    joint.solimp_friction[:2] = impedance


def soften(
    joint: Any,  # noqa: ANN401 (MjsJoint)
    share: float,
    hard: tuple[float, float],
    soft: tuple[float, float],
) -> None:
    """Give a joint's friction constraint 1/b and 1 − d at a share of the way between two constraints (b, d)."""
    damping = 1 / ((1 - share) / hard[0] + share / soft[0])
    set_constraint(joint, damping, hard[1] + share * (soft[1] - hard[1]))


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
