"""An effect is not dropped for what a fit without it shows that was given up on its way."""

from dataclasses import replace

import numpy as np
import pytest
from refit_machines import effect_of, fits_of, push

from dr_lab.diagnosis.evidence.bench import FittedModel, fit_and_score
from dr_lab.diagnosis.evidence.paired_gain import Gain
from dr_lab.diagnosis.search.deletions import Deletions
from dr_lab.diagnosis.search.pruning import prune
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.diagnosis.settings import EvidenceSettings


class Foretold(Deletions):
    """Fits that are given up where a goal is asked of them, or reach it."""

    reached = False

    def without(
        self, base: FittedModel, steps: tuple[AddedEffect, ...], place: int, goal: float = np.inf
    ) -> tuple[tuple[AddedEffect, ...], FittedModel]:
        del steps, place
        cost = (0.5 if self.reached else 2.0) * goal if np.isfinite(goal) else base.fit.cost
        return (), replace(base, fit=replace(base.fit, cost=cost))


class OnlyAtItsEnd:
    """A rule by which an effect stays that is asked for the second time."""

    def __init__(self) -> None:
        self.asked = list[Gain]()

    def __call__(self, gain: Gain, count: int, settings: EvidenceSettings) -> bool:
        del count, settings
        self.asked.append(gain)
        return len(self.asked) > 1


@pytest.mark.parametrize(("reached", "stays"), [(False, True), (True, False)], ids=["given up", "to its end"])
def test_a_deletion_that_was_given_up_is_fitted_to_its_end_before_it_counts(*, reached: bool, stays: bool) -> None:
    fits = fits_of(push)
    model = fits.base.model.with_effect(effect_of("constant_offset"))
    steps = (AddedEffect(fit_and_score(fits.bench, model, model.space.nominal), ()),)
    deletions, rule = Foretold(fits.bench), OnlyAtItsEnd()
    deletions.reached = reached
    found = prune(deletions, fits.base, steps, rule)
    kept, dropped = found.steps, found.dropped
    assert kept == (steps if stays else ())
    assert dropped == (() if stays else ("constant_offset@hinge",))
    assert len(rule.asked) == (2 if stays else 1)
