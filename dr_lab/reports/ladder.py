"""The models of a report in the order of their making, and what each is called."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

# Verdicts of a report that name no effect, although the ranking of one of its models may have a best one.
_NAMING_NONE = ("unexplained", "none", "not_excited")


@dataclass(frozen=True)
class LadderModel:
    """One model of the ladder.

    Attributes:
        name: what it is, or what it has beyond the model before it, e.g. ``+ coulomb_friction@arm``.
        effects: labels of all its effects.
        held_out: its errors on held-out logs, or on those that `scored` says, as in `gap.schema.json`.
        parameters: its parameters, likewise.
    """

    name: str
    effects: tuple[str, ...]
    held_out: Mapping[str, Any]
    parameters: Mapping[str, Any]


def steps(report: Mapping[str, Any]) -> list[LadderModel]:
    """The models from the one given to the last: as given (where the report has it apart), calibrated, with effects."""
    rungs = [report["as_given"], *report["ladder"]] if "as_given" in report else report["ladder"]
    made: list[LadderModel] = []
    for rung in rungs:
        effects = tuple(rung["effects"])
        before = made[-1].effects if made else ()
        new = [f"+ {effect}" for effect in effects if effect not in before]
        plain = "calibrated" if made else "model as given"
        made.append(LadderModel(" ".join(new) or plain, effects, rung["held_out"], rung["parameters"]))
    return made


def failing(report: Mapping[str, Any]) -> str:
    """The model whose places of failure, horizons and correlations a report tells: the first of its ladder."""
    return "calibrated model" if "as_given" in report else "model as given"


def scored(report: Mapping[str, Any]) -> str:
    """Which logs the errors of a report are from: ``held-out logs``, or ``fit logs`` where none is held out."""
    return "held-out logs" if report.get("logs", {}).get("held_out", True) else "fit logs"


def before_after(report: Mapping[str, Any]) -> list[LadderModel]:
    """The two models that a report sets side by side, or the only one.

    After is the last of the ladder. Before is the ladder's first, which is calibrated, so that the difference is the
    effects' doing; a ladder of one (calibration alone) is set beside the model as given.
    """
    made = steps(report)
    if len(made) == 1:
        return made
    return [made[-len(report["ladder"])] if len(report["ladder"]) > 1 else made[0], made[-1]]


def candidate_name(row: Mapping[str, Any]) -> str:
    """Name of a candidate of the ranking, ``effect@site``."""
    return f"{row['effect']}@{row['site']}"


def judged(word: str, verdict: str | None) -> str:
    """What a ranking says, in words that do not contradict the whole report's verdict."""
    return "best, not named" if word == "named" and verdict in _NAMING_NONE else word.replace("_", " ")


def status(row: Mapping[str, Any], verdict: str | None) -> str:
    """Status of a candidate in words; one whose place free parameters take is not among the rivals of the verdict."""
    if row.get("absorbed_by_parameters") and row["status"] == "equivalent":
        return "absorbed"
    if row["status"] == "rejected" and not row.get("fitted", True):
        return "not fitted"
    return judged(row["status"], verdict)
