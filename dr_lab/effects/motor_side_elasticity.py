"""A shaft, belt or harmonic drive that twists between motor and link, where the encoder sits at the motor."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dr_lab.effects.joint_elasticity import JointElasticity, Twisting
from dr_lab.effects.motor_side import FedBackAtMotor, FedBackEffect
from dr_lab.physics.law import Influence, Moment
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class MotorSideElasticity(FedBackEffect, JointElasticity):
    """As `JointElasticity`, but the encoder and the position controller's feedback are the motor's, as usual of servos.

    Link and motor move as there. The encoder reads q + δ, and a window begins where q + δ is as measured. Before a
    window's start the motor is where the measurements are, so that the spring bears T = tau_m − J (q + δ)'', and
    δ + eta δ' = C T.

    Parameters (nominal = absent): as of `JointElasticity`; the rotor is at least so heavy that the feedback of the
    actuators, which is taken at the start of a step, stops it within the step and no sooner: J ≥ h K_v + h² K_p.
    Limits: driven hinge and slide joints; the motor's friction and the joint's stay with the link; other sensors of
    the model see the link, and so do observations in training. Far below the resonance the link is as heavy as before,
    and the logs tell nothing.
    Source: as of `JointElasticity`; De Luca and Book, Springer Handbook of Robotics (2016), chapter 11.
    """

    name: ClassVar[str] = "motor_side_elasticity"
    law: ClassVar[str] = "J (q + delta)'' = tau_m - T, T = (delta + eta delta')/C, encoder reads q + delta"
    fingerprint: ClassVar[str] = (
        "residual that rings at one frequency after jumps of the command; the motor answers lightly"
    )
    confused_with: ClassVar[tuple[str, ...]] = ("joint_elasticity", "backlash", "armature", "presliding_friction")

    def motor_law(self) -> type[Twisting]:
        """Of a motor and its link."""
        return _AtMotor


@dataclass
class _AtMotor(FedBackAtMotor, Twisting):
    """Spring and damper between rotor and link, the measurements being the rotor's."""

    def follow(self, torque: Array) -> None:
        """Let the spring yield for a step under a torque that it bears."""
        end, left = self.compliance * torque, np.exp(-self.step / self.retardation)
        self.rate = (end - self.offset) * left / self.retardation
        self.offset = end + (self.offset - end) * left

    def replay_history(self, moment: Moment, influence: Influence) -> None:
        """Follow the measured motion, which is the motor's, under what the actuators give at its commands."""
        given = self.drive.force(moment.qpos, moment.qvel, self._arriving(influence.control))
        torque = given - self._inertial(moment)
        self._meet(torque)
        self.follow(torque)

    def read_encoders(self, qpos: Array, qvel: Array) -> None:
        """The motor's position and velocity."""
        qpos[:, self.drive.address] += self.offset
        qvel[:, self.drive.dof] += self.rate

    def place_joints(self, qpos: Array, qvel: Array) -> None:
        """The link's position and velocity; the same as the motor's where nothing before tells the twist."""
        if len(self.offset) == len(qpos):
            qpos[:, self.drive.address] -= self.offset
            qvel[:, self.drive.dof] -= self.rate
