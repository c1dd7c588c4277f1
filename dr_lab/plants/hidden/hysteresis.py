"""A transmission that gives way before it slips."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.bounds import NotNegative, Positive
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.memory import Bristle


@dataclass(frozen=True)
class Hysteresis(HiddenEffect):
    """τ = −torque z / displacement with z' = q' (1 − sign(q') z / displacement): a spring that yields bit by bit.

    Source: Dahl, A solid friction model, Aerospace Corporation TOR-0158 (1968), with exponent 1.

    Attributes:
        site: joint.
        torque: N·m or N.
        displacement: rad or m.
    """

    name: ClassVar[str] = "hysteresis"
    site: str
    torque: NotNegative
    displacement: Positive

    def memories(self) -> tuple[Bristle, ...]:
        """How far the spring is bent."""
        return (Bristle(self.site, self._rate, self._force),)

    def _rate(self, bent: float, velocity: float) -> float:
        return velocity - abs(velocity) * bent / self.displacement

    def _force(self, bent: float, rate: float, velocity: float) -> float:
        del rate, velocity
        return -self.torque * bent / self.displacement
