"""A cheap first look at every candidate: what one linear step could gain."""

from dataclasses import dataclass, replace

import numpy as np

from dr_lab.diagnosis.evidence.typical import deviance
from dr_lab.diagnosis.fit.fit import Fit, movable
from dr_lab.diagnosis.fit.identifiability import Identifiability, identifiability
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.normal_equations import Decrease
from dr_lab.diagnosis.fit.point import Mask
from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.context import ContextSpace
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class FirstLook:
    """One candidate, linearised at absent and at its further starts.

    Attributes:
        absent: the linearised fit where the effect is absent; its slopes are the base's alone, to save memory.
        starts: contexts of the further starts, shape (n,) each.
        best: context of the best of these linear steps, shape (n,).
        identifiability: what the data can say of it.
        gain: by how much farther the fit's cost could fall by that step than by one without the effect.
        evidence: what the best of these steps gains so window by window, as `deviance` counts it: one wild window
            counts little, and what gets worse counts, too.
    """

    absent: Fit
    starts: tuple[Array, ...]
    best: Array
    identifiability: Identifiability
    gain: float
    evidence: float


def look(fitter: Fitter, effect: PlacedEffect, base: Fit, alone: Decrease) -> FirstLook:
    """Linearise a candidate beside a fit of the model without it.

    At absent the model is the base, so the base's residuals and slopes are the candidate's; elsewhere the slopes are
    near. Absent costs a simulation of the windows for each parameter of the effect, a further start one more, all of
    them in one batch. What a step of the base alone would gain, where its fit did not converge, is no effect's merit.

    Args:
        fitter: of the model with the effect.
        effect: the candidate.
        base: the fit without it.
        alone: what a step of the base alone would gain (`own_step`).
    """
    space = fitter.replay.model.space
    nominal = np.append(base.z, [p.nominal for p in effect.parameters])
    rows = [nominal]
    for start in effect.starts:
        rows.append(nominal.copy())
        for name, value in start.items():
            rows[-1][space.index(name)] = value
    fits = fitter.outlooks(np.stack(rows), base.delta, base.slopes, base)
    known = [identifiability(fit.first, len(effect.parameters)) for fit in fits]
    steps = [fit.first.full_step(free(fitter, fit)) for fit in fits]
    gains = [fit.below(base) + step.total - alone.total for fit, step in zip(fits, steps, strict=True)]
    absent, best = replace(fits[0], slopes=base.slopes), int(np.argmax(gains))
    evidence = max(_evidence(fitter, fit, step, base, alone) for fit, step in zip(fits, steps, strict=True))
    return FirstLook(absent, tuple(rows[1:]), rows[best], max(known, key=lambda i: i.alone), gains[best], evidence)


def own_step(base: Fit, space: ContextSpace) -> Decrease:
    """What a full linear step of a fit would gain within the bounds of its own space, as its certificate has it."""
    unit, equations = space.to_unit(base.z), base.equations
    return equations.full_step(movable(unit, equations.slope), (np.minimum(-unit, 0.0), np.maximum(1.0 - unit, 0.0)))


def linear_gain(fitter: Fitter, fit: Fit, base: Fit, space: ContextSpace) -> float:
    """By how much farther a full linear step leads than one of a base alone, whose contexts lie in that space.

    Parameters that a step would push through their bounds stay.
    """
    return fit.below(base) + fit.first.decrease(free(fitter, fit)) - own_step(base, space).total


def _evidence(fitter: Fitter, fit: Fit, step: Decrease, base: Fit, alone: Decrease) -> float:
    """What a full linear step gains over one of the base alone in the windows that both simulate."""
    left, beside = (np.maximum(it.window_costs - by.windows, 0.0) for it, by in ((fit, step), (base, alone)))
    both, count = ~(fit.infeasible | base.infeasible), fitter.replay.fitted.sum(1)
    return float((deviance(beside, count) - deviance(left, count))[both].sum())


def free(fitter: Fitter, fit: Fit) -> Mask:
    """Parameters that a linear step from the start of a fit would not push through their bounds, shape (n,)."""
    return movable(fitter.space.to_unit(fit.z), fit.first.slope)
