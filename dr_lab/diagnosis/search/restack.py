"""Steps of a ladder on top of others than they stood on, and rivals in the place of earlier effects."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, fit_and_score
from dr_lab.diagnosis.evidence.paired_gain import paired_gain
from dr_lab.diagnosis.evidence.support import supported
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.step import AddedEffect


def reconsider(
    bench: Bench, base: FittedModel, steps: tuple[AddedEffect, ...], places: Sequence[int]
) -> tuple[AddedEffect, ...]:
    """Try every alternative of some effects in its place, beside all others that there are now.

    A rival that was added itself since then stands beside the effect, not in its place.

    Args:
        bench: data and settings.
        base: the calibrated model.
        steps: what was added.
        places: of the effects beside which others were added, or dropped, since they were judged.
    """
    for place in places:
        for rival in steps[place].alternatives:
            added = {other.fitted_model.model.effects[-1].label for k, other in enumerate(steps) if k != place}
            if rival.effect.label in added:
                steps = _without(steps, place, rival)
                continue
            swapped = swap(bench, base, steps, place, rival)
            ours, theirs = steps[-1].fitted_model.held_out, swapped[-1].fitted_model.held_out
            if supported(paired_gain(ours, theirs, bench.evidence), 0, bench.evidence):
                steps = swapped
            elif supported(paired_gain(theirs, ours, bench.evidence), 0, bench.evidence):
                steps = _without(steps, place, rival)
    return steps


def stacked(
    bench: Bench, base: FittedModel, below: Sequence[AddedEffect], above: Sequence[AddedEffect], goal: float = np.inf
) -> tuple[AddedEffect, ...]:
    """Steps on top of others than they stood on, refitted where that matters; of its `goal` see `Fitter.run`."""
    found = list(below)
    for step in above:
        ground, wanted = found[-1].fitted_model if found else base, goal if step is above[-1] else np.inf
        found.append(replace(step, fitted_model=_on(bench, ground, step.fitted_model, wanted)))
    return tuple(found)


def _without(steps: tuple[AddedEffect, ...], place: int, rival: Candidate) -> tuple[AddedEffect, ...]:
    return (*steps[:place], steps[place].without(rival), *steps[place + 1 :])


def swap(
    bench: Bench, base: FittedModel, steps: Sequence[AddedEffect], place: int, rival: Candidate
) -> tuple[AddedEffect, ...]:
    """The steps with a rival at one place, later models refitted; what it replaced is no rival of it.

    Args:
        bench: data and settings.
        base: the calibrated model.
        steps: what was added.
        place: of the effect that goes.
        rival: of that effect.
    """
    swapped = replace(steps[place].without(rival), fitted_model=rival.fitted_model)
    return stacked(bench, base, steps[:place], (swapped, *steps[place + 1 :]))


def _on(bench: Bench, below: FittedModel, fitted_model: FittedModel, goal: float) -> FittedModel:
    """The last effect of a fitted model on top of another model; refitted where that is not what it stood on."""
    *others, last = fitted_model.model.effects
    if [e.label for e in others] == [e.label for e in below.model.effects]:
        return fitted_model
    model, values = below.model.with_effect(last), fitted_model.values() | below.values()
    start = model.space.vector({name: value for name, value in values.items() if name in model.space.names})
    return fit_and_score(bench, model, start, below.fit.delta, goal)
