"""A richer effect where it acts as its special case does: what could its further parameters gain from there?"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.point import Mask
from dr_lab.diagnosis.fit.slopes import Slopes
from dr_lab.diagnosis.search.screen import free
from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.model import Model
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


class Further(NamedTuple):
    """A richer effect at the fit of its special case.

    Attributes:
        fit: linearised there.
        gain: by how much less the cost could fall by a linear step if the further parameters stayed where they are.
    """

    fit: Fit
    gain: float


def special_case(richer: PlacedEffect, among: Sequence[PlacedEffect]) -> int | None:
    """Place of a special case of an effect that the effect can act as exactly, at the same site; None if there is none.

    A special case that is a mere limit, or whose parameters are no quantities of the richer one, does not count.
    """
    bounds = {p.name.removeprefix(f"{richer.label}."): p for p in richer.parameters}
    for place, poorer in enumerate(among):
        case = richer.effect.holds.get(poorer.effect.name)
        if case is None or not case.same or poorer.site != richer.site:
            continue
        if all(bounds[name].low <= 0.0 <= bounds[name].high for name in case.further):
            return place
    return None


def holds(richer: PlacedEffect, poorer: PlacedEffect) -> bool:
    """Whether an effect is a special case of another one at its site, if only in the limit."""
    return richer.site == poorer.site and poorer.effect.name in richer.effect.holds


def special_cases(placed: Sequence[PlacedEffect], richer: Sequence[int], among: Sequence[int]) -> dict[int, int]:
    """Place of an effect's special case among some others, by the effect's place; only where there is one."""
    cases = {k: special_case(placed[k], [placed[j] for j in among]) for k in richer}
    return {k: among[place] for k, place in cases.items() if place is not None}


def limits(placed: Sequence[PlacedEffect], richer: Sequence[int], among: Sequence[int]) -> dict[int, int]:
    """Place of the plainest effect that each of some is like in a mere limit, by the place; only where there is one.

    It has fewer parameters, so that no two wait for each other, and some in common.
    """
    plain = sorted(among, key=lambda j: len(placed[j].parameters))

    def limit(k: int) -> int | None:
        fewer = (j for j in plain if len(placed[j].parameters) < len(placed[k].parameters))
        return next((j for j in fewer if holds(placed[k], placed[j]) and shared(placed[k], placed[j])), None)

    return {k: j for k in richer if (j := limit(k)) is not None}


def shared(effect: PlacedEffect, other: PlacedEffect) -> Mapping[str, str]:
    """The quantities that an effect has in common with one at its site, its short name → the other's.

    There are none unless one of the two is a special case of the other.
    """
    if holds(effect, other):
        return effect.effect.holds[other.effect.name].same
    return {its: ours for ours, its in shared(other, effect).items()} if holds(other, effect) else {}


def taking_over(effect: PlacedEffect, model: Model, values: Mapping[str, float]) -> PlacedEffect:
    """An effect that begins, away from absent, as what its special cases do at its site in a model, without them.

    Beside them only the sum of both would be known: a fit goes a long way to where one of them alone is. Special cases
    that are absent leave the starts as they are.

    Args:
        effect: the effect, which may not be in the model.
        model: the model.
        values: its context by name.
    """
    placed = (each for each in model.effects if isinstance(each, PlacedEffect))
    begun = dict[str, float]()
    for poorer in (each for each in placed if holds(effect, each) and shared(effect, each)):
        if all(values[name] == nominal for name, nominal in poorer.absent.items()):
            continue
        for ours, its in shared(effect, poorer).items():
            name = f"{effect.label}.{ours}"
            begun[name] = begun.get(name, 0.0) + values[f"{poorer.label}.{its}"]
        begun |= poorer.absent
    if not begun:
        return effect
    bounds = {p.name: (p.low, p.high) for p in effect.parameters}
    inside = {name: float(np.clip(value, *bounds.get(name, (value, value)))) for name, value in begun.items()}
    starts = [{**start, **inside} for start in effect.starts]
    return replace(effect, starts=tuple(start for k, start in enumerate(starts) if start not in starts[:k]))


def reaching(effect: PlacedEffect, other: PlacedEffect) -> PlacedEffect:
    """An effect with the bounds of its special case, or of a richer one that it is a special case of, that were moved.

    So it can still act as the other one does.
    """
    looked = {name for name, *_ in other.looked}
    moved = {p.name.removeprefix(f"{other.label}."): p for p in other.parameters if p.name in looked}
    same = shared(effect, other)

    def as_far(parameter: Parameter) -> Parameter:
        its = moved.get(same.get(parameter.name.removeprefix(f"{effect.label}."), ""))
        if its is None:
            return parameter
        return replace(parameter, low=min(parameter.low, its.low), high=max(parameter.high, its.high))

    return effect.moved(tuple(map(as_far, effect.parameters)))


def further(fitter: Fitter, richer: PlacedEffect, poorer: PlacedEffect, fit: Fit, values: dict[str, float]) -> Further:
    """What a richer effect could gain beyond the fit of its special case, by the best of its shapes (a score test).

    Args:
        fitter: of the model with the richer effect.
        richer: the effect, `reaching` its special case.
        poorer: the special case.
        fit: of the same windows with the poorer effect, which is the last of its model.
        values: the context of that fit by name.
    """
    count = len(fit.z) - len(poorer.parameters)
    known = Slopes(fit.slopes.state, fit.slopes.parameter[..., :count])
    contexts = _acting_as(richer, poorer, fitter.space, values)
    names = {f"{richer.label}.{name}" for name in richer.effect.holds[poorer.effect.name].further}
    held = np.array([name in names for name in fitter.space.names])
    found = [Further(each, _gain(fitter, each, held)) for each in fitter.outlooks(contexts, fit.delta, known)]
    return max(found, key=lambda each: each.gain)


def in_the_limit(
    richer: PlacedEffect,
    limit: PlacedEffect,
    space: ContextSpace,
    own: Mapping[str, float],
    values: Mapping[str, float],
) -> Array:
    """The context of a fit with an effect's limit, the effect's further parameters being its own, shape (n,).

    Args:
        richer: the effect.
        limit: what it is like in the limit.
        space: of the model with the effect.
        own: a context with the effect, by name.
        values: the context with the limit, by name.
    """
    case = richer.effect.holds[limit.effect.name]
    shared = {name: value for name, value in values.items() if name in space.names}
    alike = {f"{richer.label}.{name}": values[f"{limit.label}.{to}"] for name, to in case.same.items()}
    return space.clip(space.vector({**own, **shared, **alike}))


def _gain(fitter: Fitter, fit: Fit, held: Mask) -> float:
    movable = free(fitter, fit)
    return fit.first.decrease(movable) - fit.first.decrease(movable & ~held)


def _acting_as(richer: PlacedEffect, poorer: PlacedEffect, space: ContextSpace, values: dict[str, float]) -> Array:
    """Contexts in which the richer effect acts as its special case, one for each shape that it starts with, (c, n)."""
    case, ours, theirs = richer.effect.holds[poorer.effect.name], richer.label, poorer.label
    fixed = {name: value for name, value in values.items() if name in space.names}
    fixed |= {f"{ours}.{name}": values[f"{theirs}.{to}"] for name, to in case.same.items()}
    fixed |= {f"{ours}.{name}": 0.0 for name in case.further}
    shapes = {f"{ours}.{name}" for name in richer.effect.shapes}
    starts = [{name: value for name, value in start.items() if name in shapes} for start in richer.starts]
    contexts = [space.clip(space.vector({**start, **fixed})) for start in starts or [{}]]
    return np.unique(np.stack(contexts), axis=0)
