"""Two phenomena at once."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.command import Command
from dr_lab.plants.dry_friction import DryFriction
from dr_lab.plants.hidden.effect import HiddenEffect, Law, Motor, Oscillator
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class Both(HiddenEffect):
    """The second on top of the first: a command passes the first, then the second.

    Attributes:
        first: a phenomenon.
        second: another one.
        site: none of its own.
    """

    name: ClassVar[str] = "both"
    first: HiddenEffect
    second: HiddenEffect
    site: str = ""

    @property
    def label(self) -> str:
        """``name@site + name@site``."""
        return f"{self.first.label} + {self.second.label}"

    @property
    def parameters(self) -> dict[str, object]:
        """Magnitudes of each, by its label."""
        return {effect.label: effect.parameters for effect in (self.first, self.second)}

    def alter(self, machine: Machine) -> Machine:
        """Altered by both."""
        return self.second.alter(self.first.alter(machine))

    def forces(self) -> tuple[tuple[str, Law], ...]:
        """The forces of both."""
        return self.first.forces() + self.second.forces()

    def frictions(self) -> tuple[DryFriction, ...]:
        """The dry frictions of both, which sit at two joints."""
        return self.first.frictions() + self.second.frictions()

    def oscillators(self) -> tuple[Oscillator, ...]:
        """What swings in either."""
        return self.first.oscillators() + self.second.oscillators()

    def motors(self) -> tuple[Motor, ...]:
        """The motors of both, which sit at two joints."""
        return self.first.motors() + self.second.motors()

    def command(self, actuator: str, command: Command) -> Command:
        """What the second makes of what the first makes of the command."""
        return self.second.command(actuator, self.first.command(actuator, command))

    def reading_delay(self, joint: str) -> float:
        """Both delays."""
        return self.first.reading_delay(joint) + self.second.reading_delay(joint)

    def reading_bias(self, joint: str) -> float:
        """Both biases."""
        return self.first.reading_bias(joint) + self.second.reading_bias(joint)
