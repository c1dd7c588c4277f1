"""A belt, cable or spring that couples two joints."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.bare_tendon import add_bare_tendon
from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect, slides
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter

Start = Mapping[str, float]

_UNSET = -1.0  # springlength by which MuJoCo means the tendon's length in the joints' rest positions


@dataclass(frozen=True)
class JointCoupling(JointEffect, SpecEdit):
    """An elastic coupling of a joint with the one before it: a belt, a tendon over two pulleys, a spring.

    With q₂ of the joint and q₁ of the one before it, the energy is k (q₁ − r q₂ − c)²/2, so that
    tau₁ = −k (q₁ − r q₂ − c) and tau₂ = r k (q₁ − r q₂ − c): MuJoCo's fixed tendon with stiffness
    (``joint_coupling@<joint>``).

    Parameters (nominal = absent): stiffness k ≥ 0 [N·m/rad, slides: N/m]; ratio r [1] and rest c [rad, slides: m],
    which act only where k > 0.
    Limits: two hinges or two slides of the same chain, with no other hinge or slide between. An encoder behind a belt,
    which reads q₂ + r q₁, is no force.
    Source: Hooke's law along a cable over pulleys; MuJoCo 4.0, XML reference, tendon/fixed.

    Attributes:
        factor: largest k, in units of the joint's torque/range in the logs.
        least: smallest upper bound of k, for joints that hardly move [N·m/rad or N/m].
        largest_ratio: largest |r|.
        least_rest: smallest bound of |c| [rad or m].
        start: k of the fits that start away from absent, share of its upper bound; they have r = ±1.
    """

    factor: float
    least: float
    largest_ratio: float
    least_rest: float
    start: float

    name: ClassVar[str] = "joint_coupling"
    family: ClassVar[str] = "transmission"
    law: ClassVar[str] = "tau1 = -k (q1 - r q2 - c), tau2 = -r tau1"
    fingerprint: ClassVar[str] = "force residual at two joints at once, proportional to a difference of their positions"
    confused_with: ClassVar[tuple[str, ...]] = ("spring", "constant_offset", "centre_of_mass_offset", "payload")
    shapes: ClassVar[tuple[str, ...]] = ("ratio", "rest")

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the hinges and slides that have one of their kind before them in the chain."""
        return tuple(joint for joint in super().sites(model) if before(model, joint))

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """Stiffness, ratio and rest."""
        pair, slide = (before(model, site), site), slides(model, site)
        span = min((scales.position.get(joint, 0.0) for joint in pair), default=0.0)
        torque = max(scales.torque.get(joint, 0.0) for joint in pair)
        high = max(self.factor * torque / span if span else 0.0, self.least)
        far = [max(abs(scales.lowest.get(j, 0.0)), abs(scales.highest.get(j, 0.0))) for j in pair]
        rest = max(far[0] + self.largest_ratio * far[1], self.least_rest)
        return (
            Parameter("stiffness", "N/m" if slide else "N·m/rad", 0.0, 0.0, high),
            Parameter("ratio", "1", 0.0, -self.largest_ratio, self.largest_ratio),
            Parameter("rest", "m" if slide else "rad", 0.0, -rest, rest),
        )

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Add the tendon."""
        tendon = add_bare_tendon(spec, f"{self.name}@{site}")
        tendon.wrap_joint(_before(spec, site), 1.0)
        tendon.wrap_joint(site, -values["ratio"])
        tendon.stiffness = [values["stiffness"], 0.0, 0.0]
        rest = values["rest"] if values["rest"] != _UNSET else np.nextafter(_UNSET, 0.0)
        tendon.springlength = [rest, rest]

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Start, ...]:
        """A light coupling of either sign."""
        stiffness = self.start * parameters[0].high
        return tuple({"stiffness": stiffness, "ratio": ratio} for ratio in (1.0, -1.0))


def before(model: mujoco.MjModel, joint: str) -> str:
    """The named hinge or slide before a joint in its chain, if it is of the joint's kind; else nothing."""
    kind, body = int(model.joint(joint).type[0]), int(model.joint(joint).bodyid[0])
    first = int(model.body_jntadr[body])
    earlier = list(range(first, model.joint(joint).id))
    while not earlier and body > 0:
        body = int(model.body_parentid[body])
        first = int(model.body_jntadr[body])
        earlier = list(range(first, first + int(model.body_jntnum[body])))
    return model.joint(earlier[-1]).name if earlier and int(model.jnt_type[earlier[-1]]) == kind else ""


def _before(spec: mujoco.MjSpec, joint: str) -> str:
    """The same in a spec, where it is known that there is one."""
    own = spec.joint(joint)
    body = own.parent
    names = [each.name for each in body.joints]
    earlier = names[: names.index(joint)]
    while not earlier:
        body = body.parent
        earlier = [each.name for each in body.joints]
    return earlier[-1]
