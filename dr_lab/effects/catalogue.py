"""Every effect of the catalogue at every site of a model, and why some cannot sit where others of their kind can."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import mujoco

from dr_lab.effects.effect import Effect, PlacedEffect, Scales, place
from dr_lab.errors import ConfigError, ModelError
from dr_lab.physics.model import Model


@dataclass(frozen=True)
class Candidates:
    """What a model may lack.

    Attributes:
        placed: effects at sites where they can act.
        refused: why an effect cannot act at a site of its kind, by ``effect@site``.
    """

    placed: tuple[PlacedEffect, ...]
    refused: Mapping[str, str]


def candidates(
    model: Model,
    effects: Mapping[str, Effect],
    scales: Scales,
    compiled: mujoco.MjModel,
    channels: Collection[str] | None = None,
) -> Candidates:
    """Put every effect of the catalogue at every site of the model that does not hold it yet.

    Args:
        model: the model.
        effects: the catalogue, by name.
        scales: size of the effects' bounds.
        compiled: the compiled nominal model without effects, which tells the sites.
        channels: what is measured, so that effects are left out that it cannot show as their own; None leaves none out.
    """
    placed: list[PlacedEffect] = []
    refused: dict[str, str] = {}
    taken = {effect.label for effect in model.effects}
    for effect in effects.values():
        for site in effect.sites(compiled):
            label = f"{effect.name}@{site}"
            if label in taken or not (channels is None or effect.shown_by(site, channels)):
                continue
            try:
                one = place(effect, compiled, site, scales)
                model.with_effect(one).nominal()
            except ModelError as error:
                refused[label] = str(error)
            else:
                placed.append(one)
    return Candidates(tuple(placed), refused)


@dataclass(frozen=True)
class SpecialCases:
    """The special cases of effects: poorer ones of a catalogue, at the same site.

    Attributes:
        effects: the catalogue, by name.
        scales: size of the effects' bounds.
        compiled: the compiled nominal model without effects, which tells the sites.
    """

    effects: Mapping[str, Effect]
    scales: Scales
    compiled: mujoco.MjModel

    def of(self, richer: PlacedEffect, model: Model) -> tuple[PlacedEffect, ...]:
        """Those of an effect that can act at its site of a model and that the model does not hold there yet."""
        held = {name: self.effects[name] for name in richer.effect.holds if name in self.effects}
        found = candidates(model, held, self.scales, self.compiled).placed
        return tuple(poorer for poorer in found if poorer.site == richer.site)


def require_names(effects: Mapping[str, Effect]) -> None:
    """Check that each effect goes by its own name, so that no two of a catalogue are called alike.

    Args:
        effects: the catalogue, by the names of its files.

    Raises:
        ConfigError: a file has another name than its effect.
    """
    for name, effect in effects.items():
        if name != effect.name:
            raise ConfigError(
                f"effect/{name}.yaml builds the effect {effect.name!r}. Call it effect/{effect.name}.yaml, with the "
                f"first line '# @package effects.{effect.name}'; it then takes the place of one that ships with dr_lab."
            )
