"""Something that the joint runs into."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect, joint_of, slides
from dr_lab.errors import ModelError
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class EndStop(JointEffect, SpecEdit):
    """A bumper, a cable or a housing that ends the joint's travel sooner than the model says, hard or soft.

    lower ≤ q ≤ upper: MuJoCo's joint limit. Behind a stop, the depth r behaves as r'' + 2 ζ r'/τ + r/τ² = 0
    (``solreflimit`` with time constant τ/ζ and damping ratio ζ): undamped it swings with the period 2π τ, and ζ = 1
    throws nothing back. At nominal the stops lie far beyond the travel of the fitted logs, so that no other log runs
    into them.

    Parameters (nominal = absent): upper and lower [rad, slide: m], places of the stops; time_constant τ [s] and
    damping_ratio ζ [1]. No slope at absent (fits start with a stop just inside the travel); stops that have passed one
    another are infeasible.
    Limits: hinge and slide joints without a limit, which are measured and move in the logs; τ is at least two time
    steps (MuJoCo).
    Source: MuJoCo 4.0, modeling chapter ("Solver parameters"), XML reference, joint/range and joint/solreflimit.

    Attributes:
        beyond: distance of the nominal stops from the ends of the travel, share of the travel.
        deepest: largest distance of a stop from the end of the travel, share of the travel.
        start: distances of (upper, lower) from the ends of the travel in the fits that start away from absent, shares
            of the travel; None leaves that stop at nominal.
        time_constants: nominal and largest τ, s; a joint without a limit has none of its own.
        liveliest: smallest ζ; nominal is 1.
        assumed: travel about 0 of a joint of which nothing is known [rad or m]; the stops of a run replace it.
    """

    beyond: float
    deepest: float
    start: tuple[tuple[float | None, float | None], ...]
    time_constants: tuple[float, float]
    liveliest: float
    assumed: float

    name: ClassVar[str] = "end_stop"
    family: ClassVar[str] = "transmission"
    law: ClassVar[str] = "lower <= q <= upper"
    fingerprint: ClassVar[str] = "the joint turns back hard at one place, where the model goes on"
    limited: ClassVar[tuple[str, ...]] = ("upper", "lower", "time_constant", "damping_ratio")
    divisors: ClassVar[tuple[str, ...]] = ("time_constant", "damping_ratio")
    confused_with: ClassVar[tuple[str, ...]] = ("spring",)

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the hinge and slide joints without a limit."""
        return tuple(joint for joint in super().sites(model) if not model.jnt_limited[model.joint(joint).id])

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The places of the stops, and how soft and lively they are."""
        half = self.assumed / 2
        lowest, highest = scales.lowest.get(site, -half), scales.highest.get(site, half)
        travel = highest - lowest
        if travel <= 0 or site in scales.unmeasured:
            raise ModelError("An end stop shows only at a joint that is measured and moves in the logs.")
        unit = "m" if slides(model, site) else "rad"
        top, bottom = highest + self.beyond * travel, lowest - self.beyond * travel
        deep, (constant, softest) = (self.beyond + self.deepest) * travel, self.time_constants
        hardest = min(2 * float(model.opt.timestep), constant)
        return (
            Parameter("upper", unit, top, top - deep, top),
            Parameter("lower", unit, bottom, bottom, bottom + deep),
            Parameter("time_constant", "s", constant, hardest, softest),
            Parameter("damping_ratio", "1", 1.0, self.liveliest, 1.0),
        )

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Limit the joint."""
        joint = joint_of(spec, site)
        hinge_in_degrees = spec.compiler.degree and joint.type != mujoco.mjtJoint.mjJNT_SLIDE
        places = np.array([values["lower"], values["upper"]])
        joint.range = np.degrees(places) if hinge_in_degrees else places
        joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        joint.solref_limit = [values["time_constant"] / values["damping_ratio"], values["damping_ratio"]]

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Stops just inside the travel."""
        upper, lower, *_ = parameters
        travel = upper.span / (self.beyond + self.deepest)
        top, bottom = upper.nominal - self.beyond * travel, lower.nominal + self.beyond * travel
        return tuple(
            {
                "upper": upper.nominal if above is None else top - above * travel,
                "lower": lower.nominal if below is None else bottom + below * travel,
            }
            for above, below in self.start
        )
