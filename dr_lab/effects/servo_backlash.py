"""Play between a servo's own encoder and its joint."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.backlash import Backlash, Parting
from dr_lab.effects.joint_drive import JointDrive
from dr_lab.effects.motor_side import FedBackAtMotor, fed_back_at_motor, steady_rotor
from dr_lab.physics.law import Law
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class ServoBacklash(Backlash):
    """As `Backlash`, where the position controller's feedback is the motor's: its loop does not see the play.

    So the motor is where the controller wants it, and the link anywhere within ± gap/2 of it: a spindle, belt or
    gearbox whose motor has the encoder of the loop, while a linear scale, a link's encoder or a camera gives the logs.

    Parameters (nominal = absent): as of `Backlash`; the rotor is at least so heavy that the feedback of the actuators,
    which is taken at the start of a step, stops it within the step and no sooner: J ≥ h K_v + h² K_p.
    Limits: hinge and slide joints of position controllers, whose logs are the link's. Where the encoder of the loop
    sits behind the play, as of most hobby servos, it is `Backlash`; friction of the motor itself stays with the link.
    Source: as of `Backlash`, section 3.2 (feedback of the motor).
    """

    name: ClassVar[str] = "servo_backlash"
    law: ClassVar[str] = "J (delta'' + q'') = tau_m(q + delta) while |delta| < gap/2, else rigid"
    fingerprint: ClassVar[str] = (
        "the link stays back by up to the gap and is not corrected, and moves on after reversals"
    )
    confused_with: ClassVar[tuple[str, ...]] = ("backlash", "servo_elasticity", "hysteresis", "dead_zone")

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the hinge and slide joints that a position controller drives."""
        return tuple(joint for joint in super().sites(model) if fed_back_at_motor(model, joint))

    def rotor(self, model: mujoco.MjModel, site: str) -> Parameter:
        """The inertia on the motor's side."""
        return steady_rotor(super().rotor(model, site), model, site)

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The motor in its gap."""
        drive, step = JointDrive.of(models, site), float(models[0].opt.timestep)
        return _Parting(drive, step, values["rotor"], 0.5 * values["gap"], 0.5 * self.closed)


@dataclass
class _Parting(FedBackAtMotor, Parting):
    """A rotor between two walls, with the loop's encoder."""
