"""Play between a servo's own encoder and its joint."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.effects.backlash import Backlash, Parting
from dr_lab.effects.motor_side import BehindLoop, FedBackAtMotor


@dataclass(frozen=True)
class ServoBacklash(BehindLoop, Backlash):
    """As `Backlash`, where the position controller's feedback is the motor's: its loop does not see the play.

    So the motor is where the controller wants it, and the link anywhere within ± gap/2 of it: a spindle, belt or
    gearbox whose motor has the encoder of the loop, while a linear scale, a link's encoder or a camera gives the logs.

    Parameters (nominal = absent): as of `Backlash`; the rotor is at least so heavy that the feedback of the actuators,
    which is taken at the start of a step, stops it within the step and no sooner: J ≥ h K_v + h² K_p.
    Limits: hinge and slide joints of position controllers, whose logs are the link's. Where the encoder of the loop
    sits behind the play, as of most hobby servos, it is `Backlash`; friction of the motor itself stays with the link.
    Source: as of `Backlash`.
    """

    name: ClassVar[str] = "servo_backlash"
    law: ClassVar[str] = "J (delta'' + q'') = tau_m(q + delta) while |delta| < gap/2, else rigid"
    fingerprint: ClassVar[str] = (
        "the link stays back by up to the gap and is not corrected, and moves on after reversals"
    )
    confused_with: ClassVar[tuple[str, ...]] = ("backlash", "servo_elasticity", "hysteresis", "dead_zone")

    def motor_law(self) -> type[Parting]:
        """Of a motor and its link."""
        return _Parting


@dataclass
class _Parting(FedBackAtMotor, Parting):
    """A rotor between two walls, with the loop's encoder."""
