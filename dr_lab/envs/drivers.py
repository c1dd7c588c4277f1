"""What a policy's commands go through before they reach the physics."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import mujoco

from dr_lab.errors import ModelError
from dr_lab.physics.effect_parts import CommandFilter, SpecEdit, StepwiseFilter
from dr_lab.physics.law import Law
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class DrivenModel(Model):
    """A model that is stepped without knowing what comes: its command filters act between the steps."""

    def laws(self, z: Array, models: Sequence[mujoco.MjModel]) -> tuple[Law, ...]:
        """The filters, so that all else finds commands as they leave them; then the laws of the model."""
        values, compiled = self.values(z), models[0]
        filters = tuple(
            part.driver(effect.local(values), _column(compiled, element), compiled.opt.timestep)
            for effect, element, part in self.having(StepwiseFilter)
        )
        return (*filters, *super().laws(z, models))


def stepwise(model: Model) -> DrivenModel:
    """The model as a policy drives it: its command filters act between the steps.

    Effects at sensors have no part: a task reads the state itself. Their parameters stay in the context, for a run's
    distribution to remain whole.

    Args:
        model: the machine.

    Raises:
        ModelError: an effect filters commands and cannot do so step by step. The nominal context is judged: an
            actuator's delay acts as MuJoCo's own from one and a half physics steps on, and one that is drawn below that
            is none.
    """
    nominal = model.space.mapping(model.space.nominal)
    filters = ((*each, isinstance(each[2], StepwiseFilter)) for each in model.having(CommandFilter))
    edits = ((*e, e[2].expressible(e[0].local(nominal), model.spec.option)) for e in model.having(SpecEdit))
    for effect, element, _, driven in (*filters, *edits):
        if not driven:
            raise ModelError(
                f"Effect {effect.label!r} of model {model.name!r} transforms the commands of "
                f"{element} and has no driver that does so step by step. Fit the model without it, "
                "so that other effects take its place: dr-lab close effect=[…]."
            )
    return DrivenModel(**{field.name: getattr(model, field.name) for field in fields(Model)})


def _column(compiled: mujoco.MjModel, actuator: str) -> int:
    """Column of an actuator's only command in the controls."""
    return int(compiled.actuator_ctrladr[compiled.actuator(actuator).id])
