"""What the diagnosis answered to one case, as it is kept in a file."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from dr_lab.benchmark.case import Case
from dr_lab.reports.plain import to_plain

BASE = "base"  # in a class: the model without the effect


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
        standing: how each truth stood in the ranking it was last part of: ``place``, ``fitted``, ``promised``,
            ``chi2``, ``evidence``, ``evidence_low``, ``gap``, ``status``; empty for one that was no candidate.
        classes: for truths that were not named exactly, their equivalence class: label → number of parameters.
        magnitudes: what the truth's numbers are, by the plant's names.
        fitted: own parameters of each truth that was found, by short name.
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
    standing: Mapping[str, Mapping[str, Any]]
    classes: Mapping[str, Mapping[str, int]]
    magnitudes: Mapping[str, Any]
    fitted: Mapping[str, Mapping[str, float]]
    chi2_base: float
    chi2: float
    remaining: str
    cpu: float
    wall: float

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
        case: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in fields["case"].items()}
        numbers = {k: float("nan") for k in ("chi2_base", "chi2") if fields[k] is None}
        return Outcome(**{**fields, **numbers, "case": Case(**case), "truths": tuple(fields["truths"])})
