"""Effects found by the names of their parameters in a context."""

from collections.abc import Iterable, Mapping

from dr_lab.effects.effect import Effect, Scales, place
from dr_lab.errors import UnknownNameError
from dr_lab.physics.model import Model

_UNKNOWN_MACHINE = Scales({}, {}, {}, {}, {})


def with_named_effects(model: Model, effects: Mapping[str, Effect], names: Iterable[str]) -> Model:
    """The model with every effect that a parameter's full name, ``<effect>@<site>.<parameter>``, belongs to.

    Nothing is known of the machine's magnitudes, so the bounds of the effects' parameters are the smallest they have.

    Args:
        model: the model; its own parameters may be among the names.
        effects: the catalogue, by name.
        names: parameter names; effects are added in their order.

    Raises:
        UnknownNameError: there is no such effect, or it cannot sit there.
    """
    compiled = model.nominal()
    for name in names:
        label, _, _ = name.rpartition(".")
        kind, at, site = label.partition("@")
        if name in model.space.names or not at or label in (effect.label for effect in model.effects):
            continue
        if kind not in effects:
            raise UnknownNameError("effect", kind, effects, f"the catalogue (parameter {name!r})")
        model = model.with_effect(place(effects[kind], compiled, site, _UNKNOWN_MACHINE))
    return model
