"""Effects found by the names of their parameters in a context."""

from collections.abc import Iterable, Mapping

import mujoco

from dr_lab.effects.effect import Effect, Scales, place
from dr_lab.errors import ConfigError, ModelError, UnknownNameError
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array

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
        ConfigError: a parameter is not named whose usual value only logs tell.
    """
    compiled, names = model.nominal(), list(names)
    for name in names:
        label, _, _ = name.rpartition(".")
        kind, at, site = label.partition("@")
        if name in model.space.names or not at or label in (effect.label for effect in model.effects):
            continue
        if kind not in effects:
            raise UnknownNameError("effect", kind, effects, f"the catalogue (parameter {name!r})")
        placed = place(effects[kind], compiled, site, _UNKNOWN_MACHINE)
        usual = {p.name: p.nominal for p in place(effects[kind], compiled, site, _unit_scales(compiled)).parameters}
        shapes = [p for p in placed.parameters if p.name.removeprefix(f"{label}.") in effects[kind].shapes]
        untold = [p.name for p in shapes if p.nominal != usual[p.name] and p.name not in names]
        if untold:
            raise ConfigError(
                f"{name} is given without {', '.join(untold)}, whose usual value only a machine's logs tell. Give "
                f"{'it' if len(untold) == 1 else 'them'} as well: {untold[0]}: NUMBER."
            )
        model = model.with_effect(placed)
    return model


def _unit_scales(compiled: mujoco.MjModel) -> Scales:
    """Those of a machine all of whose magnitudes are 1."""
    joints = [compiled.joint(i).name for i in range(compiled.njnt)]
    low, one = dict.fromkeys(joints, -0.5), dict.fromkeys(joints, 1.0)
    high, command = dict.fromkeys(joints, 0.5), {compiled.actuator(i).name: 1.0 for i in range(compiled.nactuator)}
    return Scales(low, high, one, one, command)


def require_possible(model: Model, z: Array, called: str) -> None:
    """Refuse values that no machine has: a negative mass, or an effect that is less than absent.

    Args:
        model: the model.
        z: its context, shape (n,).
        called: what the message calls the context.

    Raises:
        ConfigError: no machine has them.
    """
    absent = {p.name: p.low for effect in model.effects for p in effect.parameters if p.low == p.nominal}
    values = model.space.mapping(z)
    below = [
        f"{name} {values[name]:g}, expected at least {low:g}" for name, low in absent.items() if values[name] < low
    ]
    if below:
        raise ConfigError(f"{called} has {'; '.join(below)}, where the effect is absent.")
    placed = [(effect.label, effect.effect) for effect in model.effects if isinstance(effect.effect, Effect)]
    divisors = [f"{label}.{name}" for label, effect in placed for name in effect.divisors]
    naught = [f"{name} {values[name]:g}, expected above 0" for name in divisors if not values[name] > 0]
    if naught:
        raise ConfigError(f"{called} has {'; '.join(naught)}, for the law divides by it.")
    try:
        model.compile(z)
    except ModelError as error:
        raise ConfigError(f"{called} makes no machine: {error}") from error
