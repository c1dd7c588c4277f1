"""What effects at an actuator have in common."""

from typing import Any

import mujoco

from dr_lab.effects.effect import Effect
from dr_lab.errors import UnknownNameError


class ActuatorEffect(Effect):
    """An effect that sits at one named actuator with a single command."""

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the actuators with one command."""
        named = (model.actuator(i).name for i in range(model.nactuator) if int(model.actuator_ctrlnum[i]) == 1)
        return tuple(name for name in named if name)


def actuator_of(spec: mujoco.MjSpec, name: str) -> Any:  # noqa: ANN401 (MjsActuator)
    """The actuator of a spec.

    Raises:
        UnknownNameError: there is no such actuator; the message lists those that exist.
    """
    actuator = spec.actuator(name)
    if actuator is None:
        names = [a.name for a in spec.actuators if a.name]
        raise UnknownNameError("actuator", name, names, f"model {spec.modelname!r}")
    return actuator
