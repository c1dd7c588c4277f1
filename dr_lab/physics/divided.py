"""A model's time step in parts, and whole again."""

from dataclasses import replace

from dr_lab.physics.model import Model


def in_parts(model: Model, parts: int) -> Model:
    """The model with its step divided, and as long a memory of delayed commands and readings."""
    spec = model.spec.copy()
    spec.option.timestep /= parts
    for element in (*spec.actuators, *spec.sensors):
        element.nsample *= parts
    return replace(model, spec=spec, parts=model.parts * parts)


def whole(model: Model) -> Model:
    """The model with the step that was divided; itself where none was.

    Source of what it undoes: `in_parts`.
    """
    if model.parts == 1:
        return model
    spec = model.spec.copy()
    spec.option.timestep *= model.parts
    for element in (*spec.actuators, *spec.sensors):
        element.nsample //= model.parts
    found = replace(model, spec=spec, parts=1)
    vars(found)["bodies_apart"] = model.bodies_apart  # it takes compiling to tell, and the step is no part of it
    return found
