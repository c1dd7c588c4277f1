"""Effects that an environment can play: those of the physics, not those of what lies before it."""

from dataclasses import replace

import mujoco
import numpy as np

from dr_lab.errors import ModelError
from dr_lab.physics.model import Model


def require_plain_signals(model: Model, compiled: mujoco.MjModel) -> None:
    """Check that no effect transforms commands, of which a policy's step knows neither the past nor what comes.

    The nominal context is judged: an actuator's delay acts as MuJoCo's own from one and a half physics steps on; one
    that is drawn below that is none. Effects at sensors are no hindrance: a task reads the state itself, so they have
    no part. Their parameters stay in the context, for a run's distribution to remain whole.

    Args:
        model: the machine.
        compiled: it, compiled.

    Raises:
        ModelError: an effect does.
    """
    actuators = [compiled.actuator(i).name for i in range(compiled.nactuator)]
    for effect in model.effects:
        alone = replace(model, effects=(effect,))
        z, series = alone.space.nominal[None], np.zeros((1, 1, 2))
        transformed = [a for a in actuators if alone.command(z, a, series) is not series]
        if transformed:
            raise ModelError(
                f"Effect {effect.label!r} of model {model.name!r} transforms the commands of {', '.join(transformed)} "
                "before they reach the physics, which an environment does not play. Fit the model without it, so that "
                "other effects take its place: dr-lab close effect=[…]."
            )
