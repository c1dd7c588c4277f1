"""A pulsed motor that coasts between the pulses, so that its command brakes it, too."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.actuator_effect import ActuatorEffect
from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_force import acts_on, drives_joint
from dr_lab.physics.compiled_contexts import distinct
from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.law import Influence, Law, Moment
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class CoastingBridge(ActuatorEffect, ForceLaw):
    """The back-EMF of a DC motor behind an H-bridge with pulse-width modulation and fast decay (coasting).

    u → u − n |u| v, with u within the actuator's range. Current flows during the pulses alone, driven by the supply
    less the back-EMF. So both the torque and the damping grow with the length of the pulses, and any command reaches
    the no-load speed 1/n in the end, but for friction. A bridge that brakes between the pulses (slow decay) damps
    always alike: that is viscous friction.

    Parameters (nominal = absent): inverse no-load speed n ≥ 0 [s/rad, s/m] of the joint.
    Limits: actuators at a joint whose force is gain times command; the winding is fast beside the pulses.
    Source: Hughes and Drury, Electric Motors and Drives, 5th edition (2019), chapter 4 (chopper-fed DC motors,
    discontinuous current); Texas Instruments, DRV8833 data sheet, "Bridge control" (fast and slow decay).

    Attributes:
        fastest: largest n, times the joint's speed in the logs.
        least: smallest speed that is believed [rad/s or m/s].
        start: n of the fit that starts away from absent, share of its upper bound.
    """

    fastest: float
    least: float
    start: float

    name: ClassVar[str] = "coasting_bridge"
    family: ClassVar[str] = "actuator"
    law: ClassVar[str] = "u -> u - n |u| v"
    fingerprint: ClassVar[str] = "damping that grows with the command: small ones reach nearly the speed of large ones"
    confused_with: ClassVar[tuple[str, ...]] = (
        "viscous_friction",
        "torque_speed_limit",
        "command_power",
        "torque_scale",
    )
    lacks: ClassVar[str] = "the back-EMF, which damps the joint in proportion to the command's size"
    limited: ClassVar[tuple[str, ...]] = ("inverse_speed",)

    def acts_at(self, model: mujoco.MjModel, row: int) -> bool:
        """At a joint, where the force is gain times command."""
        return drives_joint(model, row)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The inverse no-load speed."""
        joint, _, slide = acts_on(model, site)
        speed = max(scales.speed.get(joint, 0.0), self.least)
        return (Parameter("inverse_speed", "s/m" if slide else "s/rad", 0.0, 0.0, self.fastest / speed),)

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """What a command loses in each step."""
        unique, which = distinct(models)
        row = unique[0].actuator(site).id
        dof = int(unique[0].jnt_dofadr[unique[0].actuator_trnid[row, 0]])
        column = int(unique[0].actuator_ctrladr[row])
        low, high = np.array([_range(model, column) for model in unique])[which].T
        force = np.abs([model.actuator_gainprm[row, 0] * model.actuator_gear[row, 0] for model in unique])[which]
        return _Braked(column, dof, low, high, force * values["inverse_speed"])

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Friction hides the no-load speed at first, and moves away from it where the damping is fitted."""
        return ({"inverse_speed": self.start * parameters[0].high},)


@dataclass(frozen=True)
class _Braked(Law):
    """Damping by one command within its range [low, high]; `unit` is that of a unit of it; each of shape (n,)."""

    column: int
    dof: int
    low: Array
    high: Array
    unit: Array

    def act(self, moment: Moment, influence: Influence) -> None:
        size = np.abs(np.clip(influence.control[:, self.column], self.low, self.high))
        influence.force[:, self.dof] -= self.unit * size * moment.qvel[:, self.dof]


def _range(model: mujoco.MjModel, column: int) -> tuple[float, float]:
    """Ends of what a command may be, by its column; infinite where it has none."""
    low, high = model.actuator_ctrlrange[column] if model.actuator_ctrllimited[column] else (-np.inf, np.inf)
    return float(low), float(high)
