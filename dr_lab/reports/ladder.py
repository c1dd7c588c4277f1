"""The models of a report in the order of their making, and what each is called."""

from dataclasses import dataclass

from dr_lab.reports.gap import GapReport
from dr_lab.reports.gap_entries import CandidateEntry, ErrorsEntry, Parameters

# Verdicts of a report that name no effect, although the ranking of one of its models may have a best one.
_NAMING_NONE = ("unexplained", "none", "not_excited")
STANDING = ("named", "equivalent")  # statuses of candidates that the answer may speak of


@dataclass(frozen=True)
class LadderModel:
    """One model of the ladder.

    Attributes:
        name: what it is, or what it has beyond the model before it, e.g. ``+ coulomb_friction@arm``.
        effects: labels of all its effects.
        held_out: its errors on held-out logs, or on those that `scored` says.
        parameters: its parameters.
    """

    name: str
    effects: tuple[str, ...]
    held_out: ErrorsEntry
    parameters: Parameters


def steps(report: GapReport) -> list[LadderModel]:
    """The models from the one given to the last: as given (where the report has it apart), calibrated, with effects."""
    rungs = report.ladder if report.as_given is None else (report.as_given, *report.ladder)
    made: list[LadderModel] = []
    for rung in rungs:
        before = made[-1].effects if made else rung.effects
        mark = ", learned" if rung.learned else ""
        new = [f"+ {effect}{mark}" for effect in rung.effects if effect not in before]
        plain = "calibrated" if made else "model as given"
        made.append(LadderModel(" ".join(new) or plain, rung.effects, rung.held_out, rung.parameters))
    return made


def kept_effects(report: GapReport) -> frozenset[str]:
    """The effects that the answer speaks of: those that were added, and those that are named or equivalent."""
    stand = (row.label for row in report.judged.ranking if row.status in STANDING)
    beside = (rival for rung in report.catalogued for rival in rung.rivals or ())
    return frozenset((*report.added, *stand, *beside))


def failing(report: GapReport) -> str:
    """The model whose places of failure, horizons and correlations a report tells: the first of its ladder."""
    return "model as given" if report.as_given is None else "calibrated model"


def scored(report: GapReport) -> str:
    """Which logs the errors of a report are from: ``held-out logs``, or ``fit logs`` where none is held out."""
    return "held-out logs" if report.logs.held_out else "fit logs"


def before_after(report: GapReport) -> list[LadderModel]:
    """The two models that a report sets side by side, or the only one.

    After is the last of the ladder. Before is the ladder's first, which is calibrated, so that the difference is the
    effects' doing; a ladder of one (calibration alone) is set beside the model as given.
    """
    made = steps(report)
    if len(made) == 1:
        return made
    return [made[-len(report.ladder)] if len(report.ladder) > 1 else made[0], made[-1]]


def judged(word: str, verdict: str | None) -> str:
    """What a ranking says, in words that do not contradict the whole report's verdict."""
    return "best, not named" if word == "named" and verdict in _NAMING_NONE else word.replace("_", " ")


def status(row: CandidateEntry, verdict: str | None) -> str:
    """Status of a candidate in words; one whose place free parameters take is not among the rivals of the verdict."""
    if row.absorbed_by_parameters and row.status == "equivalent":
        return "absorbed"
    if row.status == "rejected" and not row.fitted:
        return "not fitted"
    return judged(row.status, verdict)
