"""What a hidden effect remembers: one more number that a first-order equation moves along with the machine."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Bristle:
    """A deflection z inside a joint, from 0 on: z' = rate(z, v), and the joint feels force(z, z', v).

    Attributes:
        joint: name of the joint.
        rate: of the deflection in rad/s or m/s, from the deflection (rad or m) and the joint's velocity.
        force: in N·m or N on the joint, from the deflection, its rate and the joint's velocity.
    """

    joint: str
    rate: Callable[[float, float], float]
    force: Callable[[float, float, float], float]


@dataclass(frozen=True)
class SlowCommand:
    """What a driver makes of its command u, from the command before the first on: x' = rate(x, u); x acts.

    Attributes:
        actuator: name of the actuator.
        rate: in the command's unit per s, from x and u.
    """

    actuator: str
    rate: Callable[[float, float], float]


@dataclass(frozen=True)
class SlowInstrument:
    """What an instrument shows of a quantity x, from its value at the start on: y' = (x − y) / constant.

    Attributes:
        joint: name of the joint.
        constant: s.
    """

    joint: str
    constant: float

    def rate(self, shown: float, true: float) -> float:
        """Rate of what is shown, in the quantity's unit per s."""
        return (true - shown) / self.constant


class SlowReading(SlowInstrument):
    """What an encoder shows of a position, rad or m."""


class SlowVelocity(SlowInstrument):
    """What a tachometer shows of a velocity, rad/s or m/s."""


Memory = Bristle | SlowCommand | SlowReading | SlowVelocity
