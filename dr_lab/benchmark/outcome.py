"""What the diagnosis answered to one case, as it is kept in a file."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from dr_lab.benchmark.case import Case
from dr_lab.reports.plain import Number, from_plain, to_plain

BASE = "base"  # in a class: the model without the effect


@dataclass(frozen=True)
class Standing:
    """How a truth stood in the ranking that it was last part of.

    Attributes:
        place: in the ranking, from 1 on.
        fitted: whether it was fitted.
        promised: share of the cost that a linear step could remove.
        chi2: held-out χ² per sample with it.
        evidence: for it over the model without it.
        evidence_low: what the evidence exceeds.
        gap: share of the gap that it closes.
        status: that the verdict gives it.
    """

    place: int
    fitted: bool
    promised: Number
    chi2: Number
    evidence: Number
    evidence_low: Number
    gap: Number
    status: str


@dataclass(frozen=True)
class Outcome:
    """The answer to one case, and what is needed to score it.

    Attributes:
        case: what was asked.
        truths: what is hidden, as ``effect@site``.
        verdict: ``named``, ``equivalent``, ``none`` or ``unexplained``.
        found: for each effect that was found its label and those that the data cannot separate from it, best first;
            empty where the verdict is ``unexplained``.
        absorbed: labels of effects whose place the model's own parameters can take.
        ranking: labels of the first ranking, best first.
        standing: how each truth stood that was a candidate.
        classes: for truths that were not named exactly, their equivalence class: label → number of parameters.
        magnitudes: numbers of each truth, by the plant's names.
        fitted: own parameters of each truth that was found, by short name.
        stated: the standard deviations that are stated with them; empty in runs of older versions.
        chi2_base: held-out χ² per sample of the calibrated model.
        chi2: the same of the model with what was found.
        remaining: ``at_floor`` or ``unexplained``, what the last model leaves.
        cpu: CPU time of the diagnosis, s, without that of the logs and of the classes.
        wall: elapsed time of the same, s.
    """

    case: Case
    truths: tuple[str, ...]
    verdict: str
    found: Sequence[Sequence[str]]
    absorbed: Sequence[str]
    ranking: Sequence[str]
    standing: Mapping[str, Standing]
    classes: Mapping[str, Mapping[str, int]]
    magnitudes: Mapping[str, Mapping[str, float]]
    fitted: Mapping[str, Mapping[str, float]]
    chi2_base: float
    chi2: float
    remaining: str
    cpu: float
    wall: float
    stated: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def to_json(self) -> str:
        """As text."""
        return json.dumps(to_plain(self), ensure_ascii=False, indent=1) + "\n"

    @staticmethod
    def from_json(text: str) -> "Outcome":
        """The same back; numbers that were not finite come back as NaN.

        Raises:
            ValueError, KeyError, TypeError: the text is not that of an outcome.
        """
        fields = json.loads(text)
        truths = tuple(fields["truths"])
        read = {
            "case": from_plain(Case, fields["case"]),
            "truths": truths,
            "standing": {
                truth: from_plain(Standing, _known(each)) for truth, each in fields["standing"].items() if each
            },
            "magnitudes": numbers_of(truths, fields["magnitudes"]),
            **{key: {truth: _known(own) for truth, own in fields.get(key, {}).items()} for key in ("fitted", "stated")},
        }
        return Outcome(**{**_known(fields), **read})


def _known(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Fields of a file whose numbers that were not finite are NaN again."""
    return {key: math.nan if value is None else value for key, value in fields.items()}


def numbers_of(truths: Sequence[str], parameters: Mapping[str, object]) -> dict[str, dict[str, float]]:
    """Numbers of each truth, by the plant's names.

    Args:
        truths: what is hidden.
        parameters: those of the only truth, or of several by their labels; what is no number is left out.
    """
    found = {}
    for truth in truths:
        own = parameters.get(truth, parameters)
        assert isinstance(own, Mapping)
        numbers = {name: float(value) for name, value in own.items() if isinstance(value, int | float)}
        found |= {truth: numbers} if numbers else {}
    return found
