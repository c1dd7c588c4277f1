"""What turns a command into a force at a joint."""

from dataclasses import dataclass, replace
from typing import Protocol, Self


class Drive(Protocol):
    """An actuator on a joint."""

    def force(self, command: float, speed: float) -> float:
        """Force in N·m or N at a command and a joint speed in rad/s or m/s."""
        ...

    def scaled(self, share: float) -> Self:
        """The same drive of which only a share of the force arrives."""
        ...


@dataclass(frozen=True)
class ForceDrive:
    """The command is the force: force = gain · command.

    Attributes:
        gain: share of the command that reaches the joint, 1 for a perfect drive.
    """

    gain: float = 1.0

    def force(self, command: float, speed: float) -> float:
        """Force in N·m or N at a command in the same unit, whatever the speed."""
        del speed
        return self.gain * command

    def scaled(self, share: float) -> "ForceDrive":
        """The drive with a smaller (or larger) gain."""
        return replace(self, gain=self.gain * share)


@dataclass(frozen=True)
class Motor:
    """DC motor without inductance: force = gain · k (u − k q') / R.

    Attributes:
        constant: k, force constant in N·m/A (N/A at a slide) = back-EMF constant in V·s/rad (V·s/m).
        resistance: R in Ω.
        gain: share of the force that reaches the joint, 1 for a perfect drive.
    """

    constant: float
    resistance: float
    gain: float = 1.0

    def force(self, command: float, speed: float) -> float:
        """Force in N·m or N at a terminal voltage in V and a joint speed in rad/s or m/s."""
        return self.gain * self.constant * (command - self.constant * speed) / self.resistance

    def scaled(self, share: float) -> "Motor":
        """The motor with a smaller (or larger) gain: voltage and back-EMF act with the same share."""
        return replace(self, gain=self.gain * share)
