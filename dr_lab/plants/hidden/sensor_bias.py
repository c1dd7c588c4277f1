"""An encoder whose zero lies elsewhere."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class SensorBias(HiddenEffect):
    """reading = q + bias.

    Attributes:
        site: the joint whose encoder is off.
        bias: rad or m.
    """

    name: ClassVar[str] = "sensor_bias"
    site: str
    bias: float

    def reading_bias(self, joint: str) -> float:
        """The bias at the joint."""
        return self.bias if joint == self.site else 0.0
