"""The model that a run of `dr-lab close`, `add` or `fit` ended with."""

from collections.abc import Mapping
from dataclasses import replace

from dr_lab.effects.effect import Effect, PlacedEffect
from dr_lab.effects.learned_force import LearnedForce, read_learned_forces
from dr_lab.effects.named import with_named_effects
from dr_lab.effects.residual_force import ResidualForce
from dr_lab.errors import UnknownNameError
from dr_lab.physics.context_file import read_context
from dr_lab.physics.model import Model


def _learned(forces: Mapping[str, LearnedForce]) -> dict[str, Effect]:
    """The effect of learned forces; the factor's bounds are the run's."""
    return {ResidualForce.name: ResidualForce(1.0, forces)} if forces else {}


def from_run(run: str, model: Model, effects: Mapping[str, Effect]) -> Model:
    """The run's model with the effects that it found, at what it fitted.

    Bounds are the run's, and nominal are the fitted values: a comparison shows what the run explains of other logs, and
    training without randomisation has the corrected model.

    Args:
        run: the run folder, or its `context.yaml`.
        model: the model that the run began with.
        effects: the catalogue that it chose from, by name.

    Raises:
        ConfigError: there is no fitted context.
        UnknownNameError: its parameters are not those of the model and of effects in the catalogue.
    """
    found = read_context(run)
    forces = read_learned_forces(run)
    complete = with_named_effects(model, {**effects, **_learned(forces)}, found.space.names)
    for name in set(complete.space.names) ^ set(found.space.names):
        where = f"run {run} and the model {model.name!r} that it began with, both"
        raise UnknownNameError("parameter", name, set(complete.space.names) & set(found.space.names), where)
    fitted = {
        p.name: replace(p, nominal=float(value))
        for p, value in zip(found.space.parameters, found.space.clip(found.mean), strict=True)
    }
    return replace(
        complete,
        declared=tuple(fitted[p.name] for p in complete.declared),
        effects=tuple(
            effect.bounded(tuple(fitted[p.name] for p in effect.parameters))
            for effect in complete.effects
            if isinstance(effect, PlacedEffect)
        ),
    )
