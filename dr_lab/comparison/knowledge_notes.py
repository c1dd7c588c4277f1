"""Notes on what the logs leave open, and what is known of the machine may decide."""

from collections.abc import Collection, Iterable
from math import log

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.search.as_special_case import holds
from dr_lab.diagnosis.search.rung import Rung
from dr_lab.physics.parameter import Parameter
from dr_lab.reports.gap_entries import NoteEntry
from dr_lab.reports.quantity import in_unit, shortened

_FAR = 0.5  # of the way to its bound, in logarithms; from there on the other half of what was thought possible begins


def richer_effects(rungs: Iterable[Rung], refuted: Collection[str]) -> list[NoteEntry]:
    """Notes on effects that explain as much as what is named, with more parameters; its own richer kinds left out.

    Args:
        rungs: of a ladder.
        refuted: labels of effects that were named on one and do not stand, of which nothing is told.
    """
    told = []
    for rung in rungs:
        found = {c.effect.label: c.effect for c in rung.ranking}
        named = [found[label] for label in rung.verdict.effects]
        richer = [
            label
            for label, effect in found.items()
            if rung.verdict.status[label] == "not_needed" and not any(holds(effect, each) for each in named)
        ]
        if richer and named[0].label not in refuted:
            message = (
                f"{shortened(richer)} {'explain' if len(richer) > 1 else 'explains'} as much as {named[0].label}, with "
                "more parameters. The logs do not ask for these; what is known of the machine may."
            )
            told.append(NoteEntry(message, "not_needed"))
    return told


def changed_masses(last: FittedModel) -> list[NoteEntry]:
    """Notes on masses that ended far from what the model file says, though within their bounds."""
    values = last.values()
    free = {p.name for body in last.model.inertials for p in body.parameters}
    masses = [p for p in last.model.declared if p.unit == "kg" and p.name not in free]
    return [
        NoteEntry(
            f"{p.name} ended at {in_unit(values[p.name], p.unit)}, {values[p.name] / p.nominal:.2g} times what the "
            "model file says. If that was weighed, something else acts like a mass: take it out of the model's "
            "`parameters` and ask again. Then a payload, say, has to explain what the mass makes up for here.",
            "changed_mass",
        )
        for p in masses
        if _far(p, values[p.name])
    ]


def _far(parameter: Parameter, value: float) -> bool:
    """Whether a value lies far from the nominal one on the way to a bound, and not at it, of which others tell."""
    if not parameter.low > 0 or not parameter.low < parameter.nominal < parameter.high or any(parameter.touches(value)):
        return False
    bound = parameter.high if value > parameter.nominal else parameter.low
    return log(value / parameter.nominal) / log(bound / parameter.nominal) >= _FAR
