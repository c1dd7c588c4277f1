"""Effects that an environment can play: those of the physics, not those of what lies before or behind it."""

from dataclasses import replace

import mujoco
import numpy as np

from dr_lab.errors import ModelError
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array


def require_plain_signals(model: Model, compiled: mujoco.MjModel) -> None:
    """Check that no effect transforms commands or readings, which a policy's step neither knows ahead nor goes through.

    Args:
        model: the machine.
        compiled: it, compiled.

    Raises:
        ModelError: an effect does.
    """
    actuators = [compiled.actuator(i).name for i in range(compiled.nactuator)]
    joints = [compiled.joint(i).name for i in range(compiled.njnt)]
    channels = [f"{joint}.{kind}" for joint in joints for kind in ("position", "velocity")]
    channels += [f"sensor.{compiled.sensor(i).name}" for i in range(compiled.nsensor)]
    for effect in model.effects:
        alone = replace(model, effects=(effect,))
        z, series = alone.space.nominal[None], np.zeros((1, 1, 2))
        transformed = [a for a in actuators if alone.command(z, a, series) is not series]
        transformed += [c for c in channels if alone.reading(z, c, _as_it_is, np.zeros((1, 1))) is not _as_it_is]
        if transformed:
            raise ModelError(
                f"Effect {effect.label!r} of model {model.name!r} transforms {', '.join(transformed)} between policy "
                "and physics, which an environment does not play. Leave it out of the model for training."
            )


def _as_it_is(time: Array) -> Array:
    return time
