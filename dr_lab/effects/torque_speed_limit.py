"""A motor whose largest torque falls with its speed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.actuator_effect import ActuatorEffect
from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_force import acts_on, drives_joint
from dr_lab.effects.special_case import SpecialCase
from dr_lab.physics.compiled_contexts import distinct
from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.law import CommandLaw, Influence, Law, Moment
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class TorqueSpeedLimit(ActuatorEffect, ForceLaw):
    """The line from stall torque to no-load speed of a motor behind a torque controller, whose voltage runs out.

    −(1 + n v) ≤ i F ≤ 1 − n v, with i = 1/F_stall and n = 1/v_free. Against the motion the motor can give more than its
    stall torque, with the motion less, and beyond v_free nothing. The law bounds the command before every step.

    Parameters (nominal = absent): inverse stall torque i ≥ 0 [1/(N·m), 1/N], inverse no-load speed n ≥ 0 [s/rad, s/m],
    which act only where i > 0 and the limit is reached (fits start away from absent).
    Limits: actuators at a joint whose force is gain times command; motors driven by a voltage have it as back-EMF.
    Source: Hanselman, Brushless Permanent Magnet Motor Design (2003), chapter 1 (torque–speed curve); Hwangbo et al.,
    Science Robotics 4 (2019), on what simulated legs lack without it.

    Attributes:
        strongest: largest i, times the largest force commanded in the logs.
        fastest: largest n, times the joint's speed in the logs.
        least: smallest force and speed that are believed [N·m or N, rad/s or m/s].
        start: i and n of the fits that start away from absent, shares of their upper bounds.
    """

    strongest: float
    fastest: float
    least: float
    start: tuple[tuple[float, float], ...]

    name: ClassVar[str] = "torque_speed_limit"
    family: ClassVar[str] = "actuator"
    law: ClassVar[str] = "|F| <= F_stall (1 - sign(F) v / v_free)"
    fingerprint: ClassVar[str] = "residual only where much torque is asked for at high speed, along the motion"
    confused_with: ClassVar[tuple[str, ...]] = ("saturation", "viscous_friction", "torque_scale")
    holds: ClassVar[Mapping[str, SpecialCase]] = {"saturation": SpecialCase(("inverse_speed",))}
    shapes: ClassVar[tuple[str, ...]] = ("inverse_speed",)
    lacks: ClassVar[str] = "the bound of the command that falls with the joint's speed"

    def acts_at(self, model: mujoco.MjModel, row: int) -> bool:
        """At a joint, where the force is gain times command."""
        return drives_joint(model, row)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """Inverse stall torque and inverse no-load speed."""
        gain, (joint, gear, slide) = abs(float(model.actuator(site).gainprm[0])), acts_on(model, site)
        force = max(scales.command.get(site, 0.0) * gain, self.least)
        speed = max(scales.speed.get(joint, 0.0) * gear, self.least)
        units = ("1/N", "s/m") if slide else ("1/(N·m)", "s/rad")
        return (
            Parameter("inverse_stall", units[0], 0.0, 0.0, self.strongest / force),
            Parameter("inverse_speed", units[1], 0.0, 0.0, self.fastest / speed),
        )

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The bound of each step."""
        unique, which = distinct(models)
        row = unique[0].actuator(site).id
        dof = int(unique[0].jnt_dofadr[unique[0].actuator_trnid[row, 0]])
        column = int(unique[0].actuator_ctrladr[row])
        drives = np.array([(model.actuator_gainprm[row, 0], model.actuator_gear[row, 0]) for model in unique])
        gain, gear = drives[which].T
        return _Bounded(column, dof, gain, gear, values["inverse_stall"], values["inverse_speed"])

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Limits that the logs reach at high speed."""
        stall, speed = parameters
        return tuple(
            {"inverse_stall": share * stall.high, "inverse_speed": fast * speed.high} for share, fast in self.start
        )


@dataclass(frozen=True)
class _Bounded(CommandLaw):
    """Bound of one command; gain, gear, inverse stall torque and speed of shape (n,)."""

    column: int
    dof: int
    gain: Array
    gear: Array
    stall: Array
    speed: Array

    def act(self, moment: Moment, influence: Influence) -> None:
        share = self.speed * self.gear * moment.qvel[:, self.dof]
        force = influence.control[:, self.column] * self.gain
        relative = np.clip(self.stall * force, np.minimum(-1.0 - share, 0.0), np.maximum(1.0 - share, 0.0))
        limited = np.divide(relative, self.stall, out=force.copy(), where=self.stall > 0)
        influence.control[:, self.column] = limited / self.gain
