"""What a policy's commands go through before they reach the physics."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from dr_lab.errors import ModelError
from dr_lab.physics.law import Law
from dr_lab.physics.model import Model, ModelEffect
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.silent_effect import SilentEffect
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Drivers(SilentEffect):
    """The drivers of a model's effects as a first effect, so that all else finds commands as they leave them.

    Fulfils `physics.model.ModelEffect`.

    Attributes:
        effects: the model's effects.
        label: what stands for them among effects.
        parameters: none beside those of the effects.
    """

    effects: tuple[ModelEffect, ...]
    label: str = "drivers"
    parameters: tuple[Parameter, ...] = ()

    def drivers(self, values: Mapping[str, Array], compiled: mujoco.MjModel) -> tuple[Law, ...]:
        """The drivers, in order of the effects."""
        return tuple(law for effect in self.effects for law in effect.drivers(values, compiled))

    def force_laws(self, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> tuple[Law, ...]:
        """The drivers, as laws between steps."""
        return self.drivers(values, models[0])


def stepwise(model: Model) -> Model:
    """The model as a policy drives it, which steps without knowing what comes: drivers act between the steps.

    Effects at sensors have no part: a task reads the state itself. Their parameters stay in the context, for a run's
    distribution to remain whole.

    Args:
        model: the machine.

    Raises:
        ModelError: an effect transforms commands and has no driver for it. The nominal context is judged: an actuator's
            delay acts as MuJoCo's own from one and a half physics steps on, and one that is drawn below that is none.
    """
    compiled = model.nominal()
    actuators = [compiled.actuator(i).name for i in range(compiled.nactuator)]
    driven = False
    for effect in model.effects:
        alone = replace(model, effects=(effect,))
        z, series = alone.space.nominal[None], np.zeros((1, 1, 2))
        changed = [a for a in actuators if alone.command(z, a, series) is not series]
        found = bool(effect.drivers({name: z[:, i] for i, name in enumerate(alone.space.names)}, compiled))
        driven = driven or found
        if changed and not found:
            raise ModelError(
                f"Effect {effect.label!r} of model {model.name!r} transforms the commands of {', '.join(changed)} and "
                "has no driver that does so step by step. Fit the model without it, so that other effects take "
                "its place: dr-lab close effect=[…]."
            )
    return replace(model, effects=(Drivers(model.effects), *model.effects)) if driven else model
