"""An encoder whose zero lies elsewhere."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.trajectory import Array


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

    def reading(self, joint: str, time: Array, position: Array) -> Array:
        """The position beside the zero."""
        del time
        return position + self.bias if joint == self.site else position
