"""One effect that was added to a ladder of models."""

from dataclasses import dataclass
from typing import cast

from dr_lab.diagnosis.evidence.bench import FittedModel
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
    """

    fitted_model: FittedModel
    rivals: tuple[Candidate, ...]
    proven: bool = True

    @property
    def effect(self) -> PlacedEffect:
        """The effect, which is the last of the model's."""
        return cast(PlacedEffect, self.fitted_model.model.effects[-1])
