"""An encoder whose zero wanders."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class SensorDrift(HiddenEffect):
    """reading(t) = q(t) + rate t, t in the log.

    Attributes:
        site: the joint whose encoder drifts.
        rate: rad/s or m/s.
    """

    name: ClassVar[str] = "sensor_drift"
    site: str
    rate: float

    def reading(self, joint: str, time: Array, position: Array) -> Array:
        """What has drifted."""
        return position + self.rate * time if joint == self.site else position
