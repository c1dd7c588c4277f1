"""Dry friction whose change of sign is smooth in the velocity."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect, slides
from dr_lab.effects.special_case import SpecialCase
from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.law import Influence, Law, Moment
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

_NEAR = 1e-4  # below it a difference of ln cosh is less accurate than what lies between


@dataclass(frozen=True)
class SmoothFriction(JointEffect, ForceLaw):
    """Dry friction by a sigmoid of the velocity: a lubricated joint, or a simulator that smooths the sign.

    tau = −tau_c tanh(v/v_c), which is also tau_c (1 − 2/(1 + exp(−2 v/v_c))), the logistic form. Under a load F below
    tau_c the joint creeps at v_c artanh(F/tau_c). For v_c → 0 it is Coulomb friction. For solving the equation see
    `Sigmoid`.

    Parameters (nominal = absent): torque tau_c ≥ 0 [N·m, slide: N]; creep v_c > 0 [rad/s, slide: m/s], which acts only
    where tau_c > 0 (fits start away from absent).
    Limits: hinge and slide joints; no true rest, no Stribeck drop.
    Source: Andersson, Söderberg and Björklund, Tribology International 40 (2007) 580; the logistic form:
    Gaz, Cognetti, Oliva, Robuffo Giordano and De Luca, IEEE RA-L 4 (2019) 4147, on the Franka arm.

    Attributes:
        factor: largest tau_c, in units of the joint's torque in the logs.
        least: its smallest upper bound, for joints that hardly move [N·m or N].
        creeps: smallest, nominal and largest v_c, in units of the joint's speed in the logs.
        least_speed: smallest joint speed that is believed [rad/s or m/s].
        start_torque: tau_c of the fits that start away from absent, share of its upper bound.
        start_creeps: v_c of these fits, shares of the joint's speed.
    """

    factor: float
    least: float
    creeps: tuple[float, float, float]
    least_speed: float
    start_torque: float
    start_creeps: tuple[float, ...]

    name: ClassVar[str] = "smooth_friction"
    family: ClassVar[str] = "friction"
    law: ClassVar[str] = "tau = -tau_c tanh(v/v_c)"
    fingerprint: ClassVar[str] = "force residual that passes through zero smoothly with the velocity, then is constant"
    confused_with: ClassVar[tuple[str, ...]] = (
        "coulomb_friction",
        "presliding_friction",
        "soft_friction",
        "viscous_friction",
    )
    holds: ClassVar[Mapping[str, SpecialCase]] = {"coulomb_friction": SpecialCase(("creep",), {"torque": "torque"})}
    shapes: ClassVar[tuple[str, ...]] = ("creep",)
    divisors: ClassVar[tuple[str, ...]] = ("creep",)
    sharpened: ClassVar[tuple[str, ...]] = ("creep",)
    lacks: ClassVar[str] = "friction that passes smoothly through zero velocity"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The torque at high speed, and the speed below which it falls."""
        torque, speed = ("N", "m/s") if slides(model, site) else ("N·m", "rad/s")
        high = max(self.factor * scales.torque.get(site, 0.0), self.least)
        slow, usual, fast = (s * max(scales.speed.get(site, 0.0), self.least_speed) for s in self.creeps)
        return (Parameter("torque", torque, 0.0, 0.0, high), Parameter("creep", speed, usual, slow, fast))

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The force of each step."""
        dof = int(models[0].joint(site).dofadr[0])
        inertia = np.array([1.0 / model.dof_invweight0[dof] for model in models])
        return Sigmoid(dof, values["torque"], values["creep"], inertia)

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """A small torque at each of `start_creeps`."""
        torque, creep = parameters
        little, moving = self.start_torque * torque.high, creep.high / self.creeps[2]
        return tuple({"torque": little, "creep": share * moving} for share in self.start_creeps)


@dataclass
class Sigmoid(Law):
    """A force −torque tanh(v/creep) of a degree of freedom, by its mean over a step; values of shape (n,) or (1,).

    While v goes evenly from v₀ to v₁ the mean of the tanh is creep (ln cosh(v₁/creep) − ln cosh(v₀/creep))/(v₁ − v₀),
    which counts a reversal within the step. The force is linearised in v₁. Its slope is added to the armature, which
    makes the step implicit, so that a steep tanh needs no finer steps. The point of linearisation is a predicted v₁: it
    takes all other forces as those of the last step.
    Source: McLachlan, Quispel and Robidoux, Phil. Trans. R. Soc. A 357 (1999) 1021, the averaged vector field.

    Attributes:
        dof: degree of freedom.
        torque: at high speed, N·m or N.
        creep: speed at which the force is 0.76 of that, rad/s or m/s.
        inertia: on which the force acts, by the compiled model in its reference pose, kg·m² or kg. It only serves to
            predict v₁.
    """

    dof: int
    torque: Array
    creep: Array
    inertia: Array

    def act(self, moment: Moment, influence: Influence) -> None:
        """Add the force of a step."""
        gained = moment.gained[:, self.dof]
        start, last = (moment.qvel[:, self.dof] - gained / 2) / self.creep, gained / self.creep
        braked = self.torque * moment.step / (self.inertia * self.creep)
        end = _end(start, last + braked * _mean(start - last, start)[0], braked)
        mean, slope = _mean(start, end)
        added = self.torque * slope / self.creep * moment.step
        influence.armature[:, self.dof] += added
        influence.force[:, self.dof] += added * (end - start) * self.creep / moment.step - self.torque * mean


def _end(start: Array, driven: Array, braked: Array) -> Array:
    """About the end x of a step that obeys x = start + driven − braked · mean, within its bounds.

    One step of Newton's method from where it ends if the mean is (tanh(start) + x)/2, the trapezoidal rule of a tanh
    that is straight up to its bounds. More steps bring a motion no nearer to that of an exact solution.

    Args:
        start: speed at the start, in units of the creep, as all here.
        driven: speed that all other forces give in the step.
        braked: speed that the whole torque takes in the step.
    """
    free = start + driven
    low, high = free - braked, free + braked
    end = _within((free - 0.5 * braked * np.tanh(start)) / (1.0 + 0.5 * braked), low, high)
    mean, slope = _mean(start, end)
    return _within(end - (end - free + braked * mean) / (1.0 + braked * slope), low, high)


def _within(x: Array, low: Array, high: Array) -> Array:
    return np.minimum(np.maximum(x, low), high)


def _mean(start: Array, end: Array) -> tuple[Array, Array]:
    """The mean of tanh between two numbers, and how it changes with the second one.

    Where they are near, differences lose digits, the more the larger they are. Then it is the mean between two numbers
    with the same middle m that are 1 + |m| times `_NEAR` apart: a tanh of large numbers is 1.
    """
    middle, half = (start + end) / 2, (end - start) / 2
    half = np.copysign(np.maximum(np.abs(half), (_NEAR / 2) * (1.0 + np.abs(middle))), half)
    ends = np.empty((2, *middle.shape))  # faster than to stack two arrays, which takes as long as all exponentials here
    np.subtract(middle, half, out=ends[0])
    np.add(middle, half, out=ends[1])
    size = np.abs(ends)
    before, after = size + np.log1p(np.exp(-2.0 * size))  # ln cosh, but for a constant
    mean = (after - before) / (2.0 * half)
    slope = (np.tanh(ends[1]) - mean) / (2.0 * half)
    return mean, np.maximum(slope, 0.0)  # digits that cancel may leave less
