"""Commands that are held for long, and the controls that a model's filters, such as a dead zone, make of them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from dr_lab.diagnosis.next_experiment.standing import Standing, Stillness, standing
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array

_TRIED = 101  # commands at a time, of which the neighbours of the best bound the next ones
_ROUNDS = 8  # after which they lie closer than numbers do


@dataclass(frozen=True)
class HeldCommands:
    """What actuators get of commands that do not change.

    Attributes:
        model: the model with its effects, as recorded commands are replayed by it.
        z: its context, shape (n,).
        limits: lowest and highest command by actuator.
    """

    model: Model
    z: Array
    limits: Mapping[str, tuple[float, float]]

    def controls(self, actuator: str, commands: Array) -> Array:
        """The controls that held commands become, shape (k,) both."""
        return self.model.command(self.z[None], actuator, commands[None, :, None])[0, :, 0]

    def reached(self, actuator: str) -> tuple[float, float]:
        """Lowest and highest control that commands within their limits become."""
        found = self.controls(actuator, np.linspace(*self.limits[actuator], _TRIED))
        return float(found.min()), float(found.max())

    def command(self, actuator: str, control: float) -> float:
        """A held command that becomes a control within reach; the control itself where it passes unchanged."""
        low, high = self.limits[actuator]
        if low <= control <= high and self.controls(actuator, np.array([control]))[0] == control:
            return control
        for _ in range(_ROUNDS):
            commands = np.linspace(low, high, _TRIED)
            near = int(np.abs(self.controls(actuator, commands) - control).argmin())
            low, high = (float(commands[at]) for at in (max(near - 1, 0), min(near + 1, _TRIED - 1)))
        return (low + high) / 2


def held_standing(
    model: Model, z: Array, qpos: Array, limits: Mapping[str, tuple[float, float]], stillness: Stillness
) -> Standing:
    """How a model's machine stands at a context, held by commands that pass the model's filters first; see `standing`.

    Args:
        model: the model with its effects.
        z: its context, shape (n,).
        qpos: the pose, shape (nq,).
        limits: lowest and highest command by actuator.
        stillness: when it stands.
    """
    held = HeldCommands(model.replayed(), z, limits)
    found = standing(model.compile(z), qpos, {name: held.reached(name) for name in limits}, stillness)
    return replace(found, hold={name: held.command(name, control) for name, control in found.hold.items()})
