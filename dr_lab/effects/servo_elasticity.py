"""A shaft, belt or harmonic drive that twists between a servo's own encoder and its joint."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dr_lab.effects.joint_elasticity import JointElasticity, Twisting
from dr_lab.effects.motor_side import BehindLoop, FedBackAtMotor
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class ServoElasticity(BehindLoop, JointElasticity):
    """As `JointElasticity`, where the position controller's feedback is the motor's: its loop does not see the twist.

    The link's place is where the controller holds the motor, less C T: it sags under its load, and rings on the motor
    that stands still, at ω² = 1/(C J_link). A belt or gearbox whose motor has the encoder of the loop, while a linear
    scale, a link's encoder or a camera gives the logs.

    Parameters (nominal = absent): as of `JointElasticity`; the rotor is at least so heavy that the feedback of the
    actuators, which is taken at the start of a step, stops it within the step and no sooner: J ≥ h K_v + h² K_p.
    Limits: hinge and slide joints of position controllers, whose logs are the link's; where the logs are the motor's it
    is `MotorSideElasticity`; friction of the motor itself stays with the link.
    Source: as of `JointElasticity`; De Luca and Book, Springer Handbook of Robotics (2016), chapter 11.
    """

    name: ClassVar[str] = "servo_elasticity"
    law: ClassVar[str] = "J (q + delta)'' = tau_m(q + delta) - T, T = (delta + eta delta')/C"
    fingerprint: ClassVar[str] = (
        "the link sags under its load where the motor stands, and rings after jumps of the target"
    )
    confused_with: ClassVar[tuple[str, ...]] = (
        "joint_elasticity",
        "servo_backlash",
        "gain_error",
        "actuator_delay",
        "actuator_lag",
    )

    def motor_law(self) -> type[Twisting]:
        """Of a motor and its link."""
        return _Twisting


@dataclass
class _Twisting(FedBackAtMotor, Twisting):
    """Spring and damper between rotor and link, with the loop's encoder at the rotor."""

    def balance(self, load: Array) -> Array:
        """C times the load, which falls by K_p a twist: δ = C (load − K_p δ)."""
        stiffness = np.maximum(-self.drive.by_position, 0.0)
        return self.compliance * load / (1.0 + self.compliance * stiffness)
