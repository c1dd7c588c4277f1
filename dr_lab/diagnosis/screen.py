"""A cheap first look at every candidate: what one linear step could gain."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from dr_lab.diagnosis.fit import Fit, Fitter
from dr_lab.diagnosis.identifiability import Identifiability, identifiability
from dr_lab.diagnosis.point import Point
from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.context import ContextSpace
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Look:
    """One candidate, linearised at absent and at its further starts.

    Attributes:
        absent: the linearised fit where the effect is absent; its slopes are the base's alone, to save memory.
        starts: the further starts, with the base's states or, where they fit better, the prior's mean.
        identifiability: what the data can say of it.
        gain: by how much the fit's cost could fall below that without the effect, by the best of these linear steps.
    """

    absent: Fit
    starts: tuple[Point, ...]
    identifiability: Identifiability
    gain: float


def look(fitter: Fitter, effect: PlacedEffect, base: Fit) -> Look:
    """Linearise a candidate beside a converged fit of the model without it.

    At absent the model is the base, so the base's slopes are the candidate's; elsewhere they are near. A start costs
    three simulations of the windows and one more for each parameter of the effect.
    """
    space = fitter.replay.model.space
    nominal = np.append(base.z, [p.nominal for p in effect.parameters])
    absent = fitter.run(nominal, base.delta, base.slopes, iterations=0)
    starts = tuple(fitter.begin(_moved(space, nominal, start), base.delta) for start in effect.starts)
    fits = [absent, *(fitter.run(start.z, start.delta, base.slopes, iterations=0) for start in starts)]
    known = [identifiability(fit.first, len(effect.parameters)) for fit in fits]
    lowest = min(_reachable(fitter, fit) for fit in fits)
    return Look(replace(absent, slopes=base.slopes), starts, max(known, key=lambda i: i.alone), base.cost - lowest)


def _moved(space: ContextSpace, z: Array, values: Mapping[str, float]) -> Array:
    moved = z.copy()
    for name, value in values.items():
        moved[space.index(name)] = value
    return moved


def _reachable(fitter: Fitter, fit: Fit) -> float:
    """Cost behind a full linear step; parameters that it would push through their bounds stay."""
    unit = fitter.space.to_unit(fit.z)
    gradient = fit.first.window_information()[1].sum(0) + fit.first.prior_gradient
    return fit.cost - fit.first.decrease(_movable(unit, gradient))


def _movable(unit: Array, gradient: Array) -> np.ndarray:
    return ~(((unit <= 0) & (gradient > 0)) | ((unit >= 1) & (gradient < 0)))
