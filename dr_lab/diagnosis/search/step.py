"""One effect that was added to a ladder of models."""

from dataclasses import dataclass, replace
from typing import cast

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, fitted_for_comparison
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.effects.effect import PlacedEffect


@dataclass(frozen=True)
class AddedEffect:
    """One effect that was added.

    Attributes:
        fitted_model: the model with it.
        rivals: fitted alternatives that these data cannot separate from it, given all that was added since.
        proven: whether it was added with support, or kept when trials were over; else it is on trial, or a user added
            it.
        alike: whether it was compared with the same effect at other sites alone.
        passed: fitted alternatives that it beat, but that explain more than one of its rivals does: what is still
            missing may have decided between them.
    """

    fitted_model: FittedModel
    rivals: tuple[Candidate, ...]
    proven: bool = True
    passed: tuple[Candidate, ...] = ()
    alike: bool = False

    @property
    def alternatives(self) -> tuple[Candidate, ...]:
        """All that may take its place beside what is added later."""
        return (*self.rivals, *self.passed)

    def without(self, alternative: Candidate) -> "AddedEffect":
        """The same without one that does not take its place."""
        kept = [tuple(each for each in group if each is not alternative) for group in (self.rivals, self.passed)]
        return replace(self, rivals=kept[0], passed=kept[1])

    def ended(self, bench: Bench) -> "AddedEffect":
        """The same with its model fitted until its scores can be compared."""
        return replace(self, fitted_model=fitted_for_comparison(bench, self.fitted_model))

    @property
    def effect(self) -> PlacedEffect:
        """The effect, which is the last of the model's."""
        return cast(PlacedEffect, self.fitted_model.model.effects[-1])
