"""A cheap first look at every candidate: what one linear step could gain."""

from dataclasses import dataclass, replace

import numpy as np

from dr_lab.diagnosis.fit import Fit, Fitter, movable
from dr_lab.diagnosis.identifiability import Identifiability, identifiability
from dr_lab.effects.effect import PlacedEffect
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Look:
    """One candidate, linearised at absent and at its further starts.

    Attributes:
        absent: the linearised fit where the effect is absent; its slopes are the base's alone, to save memory.
        starts: contexts of the further starts, shape (n,) each.
        identifiability: what the data can say of it.
        gain: by how much the fit's cost could fall below that without the effect, by the best of these linear steps.
    """

    absent: Fit
    starts: tuple[Array, ...]
    identifiability: Identifiability
    gain: float


def look(fitter: Fitter, effect: PlacedEffect, base: Fit) -> Look:
    """Linearise a candidate beside a converged fit of the model without it.

    At absent the model is the base, so the base's slopes are the candidate's; elsewhere they are near. A start costs
    one simulation of the windows and one more for each parameter of the effect.
    """
    space = fitter.replay.model.space
    nominal = np.append(base.z, [p.nominal for p in effect.parameters])
    rows = [nominal]
    for start in effect.starts:
        rows.append(nominal.copy())
        for name, value in start.items():
            rows[-1][space.index(name)] = value
    fits = [fitter.run(z, base.delta, base.slopes, iterations=0) for z in rows]
    known = [identifiability(fit.first, len(effect.parameters)) for fit in fits]
    gain = max(_reachable(fitter, fit, base) for fit in fits)
    absent = replace(fits[0], slopes=base.slopes)
    return Look(absent, tuple(rows[1:]), max(known, key=lambda i: i.alone), gain)


def _reachable(fitter: Fitter, fit: Fit, base: Fit) -> float:
    """How far below the base's cost a full linear step leads; parameters that it would push through bounds stay."""
    unit = fitter.space.to_unit(fit.z)
    gradient = fit.first.window_information()[1].sum(0) + fit.first.prior_gradient
    return fit.below(base) + fit.first.decrease(movable(unit, gradient))
