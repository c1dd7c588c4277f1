"""Stops that end a joint's range."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, pi
from typing import Any, ClassVar

import mujoco

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect, joint_of, slides
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class EndStop(JointEffect):
    """Stops within the motion: a rail's ends, a cable that is taut, a housing that the link runs into.

    lower ≤ q ≤ upper, by a one-sided force that lets the penetration r behave as r'' + 2 r'/T + r/(T zeta)² = 0 while
    the joint is beyond a stop: MuJoCo's joint limit. A joint that has a range of its own keeps its constraint settings
    and whichever stop is narrower. Stops that cross leave no room, and hold the joint half-way between them.

    Parameters (nominal = absent): upper, lower [rad, slide: m], absent = outside the motion (`far` ranges of motion,
    and at least a turn or the machine's length, from the model's zero position). No slope there: fits start with stops
    inside the motion.
    Limits: hinge and slide joints; the model's zero position within a range of motion from the stops. How far the
    joint moved is known, not from where to where, and a fit finds only stops near one of its starts: those about as
    far from the zero position on both sides, or with the zero position at one of them. Actuators with ``inheritrange``
    take the narrower range too.
    Source: MuJoCo 4.0, XML reference, joint/range, and modeling chapter ("Solver parameters").

    Attributes:
        near: how far a stop may lie beyond the zero position, in units of the joint's range in the logs.
        far: where absent stops lie from the zero position, in the same unit.
        least: smallest range that is believed [rad or m].
        time_constant: T [s]; MuJoCo takes at least two time steps.
        damping_ratio: zeta; 1 = the joint does not bounce.
        impedance: share of the force that the limit may give, within (0, 1).
        gap: room that crossing stops leave [rad or m].
        start_stops: (lower, upper) of the fits that start away from absent, in units of the joint's range.
    """

    near: float
    far: float
    least: float
    time_constant: float
    damping_ratio: float
    impedance: float
    gap: float
    start_stops: tuple[tuple[float, float], ...]

    name: ClassVar[str] = "end_stop"
    family: ClassVar[str] = "transmission"
    law: ClassVar[str] = "lower <= q <= upper"
    fingerprint: ClassVar[str] = "no residual until the joint reaches a position beyond which it is never measured"
    confused_with: ClassVar[tuple[str, ...]] = ("spring", "saturation")

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The two stops."""
        slide = slides(model, site)
        zero = float(model.qpos0[model.joint(site).qposadr[0]])
        span = max(scales.position.get(site, 0.0), self.least)
        near, far = self.near * span, max(self.far * span, float(model.stat.extent) if slide else 2 * pi)
        unit = "m" if slide else "rad"
        return (
            Parameter("lower", unit, zero - far, zero - far, zero + near),
            Parameter("upper", unit, zero + far, zero - near, zero + far),
        )

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Narrow the joint's range."""
        joint = joint_of(spec, site)
        hinge = joint.type == mujoco.mjtJoint.mjJNT_HINGE
        unit = pi / 180 if hinge and spec.compiler.degree else 1.0  # of the range in the spec, in rad or m
        limited = _limited(spec, joint)
        low, high = (unit * end for end in joint.range) if limited else (-inf, inf)
        low, high = max(low, values["lower"]), min(high, values["upper"])
        if low + self.gap > high:
            low, high = (low + high - self.gap) / 2, (low + high + self.gap) / 2
        if not limited:
            joint.solref_limit = [self.time_constant, self.damping_ratio]
            joint.solimp_limit[:2] = self.impedance
            joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        joint.range = [low / unit, high / unit]

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Stops within the motion, for a zero position in its middle or at one of its ends."""
        lower, upper = parameters
        zero = (lower.nominal + upper.nominal) / 2
        span = (lower.high - zero) / self.near
        return tuple({"lower": zero + low * span, "upper": zero + high * span} for low, high in self.start_stops)


def _limited(spec: mujoco.MjSpec, joint: Any) -> bool:  # noqa: ANN401 (MjsJoint)
    """Whether the joint has a range of its own."""
    choice, (low, high) = joint.limited, joint.range
    automatic = choice == mujoco.mjtLimited.mjLIMITED_AUTO and spec.compiler.autolimits and (low, high) != (0.0, 0.0)
    return choice == mujoco.mjtLimited.mjLIMITED_TRUE or bool(automatic)
