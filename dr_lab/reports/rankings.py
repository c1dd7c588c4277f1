"""The rankings of a report, rung by rung, in the order of what they show."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

from dr_lab.reports.gap import GapReport
from dr_lab.reports.gap_entries import CandidateEntry, JudgedRungEntry
from dr_lab.reports.ladder import STANDING, judged


@dataclass(frozen=True)
class Ranking:
    """What each effect would add to one model of the ladder.

    Attributes:
        model: which model, e.g. ``calibrated model``.
        word: its verdict, in words that do not contradict the whole report's.
        reason: why.
        rows: the candidates, by what they gain.
    """

    model: str
    word: str
    reason: str
    rows: tuple[CandidateEntry, ...]

    @property
    def title(self) -> str:
        """Model and verdict, e.g. ``Calibrated model: named``."""
        name = self.model[:1].upper() + self.model[1:]
        return f"{name}: {self.word}" if self.word else name


def rankings(report: GapReport) -> list[Ranking]:
    """One for each step of the ladder; the first one's alone where a report knows no steps."""
    found = report.judged
    alone = found.ranking or found.reason
    rungs = found.rungs or ((JudgedRungEntry(report.verdict, found.reason),) if alone else ())
    return [
        Ranking(
            model=f"model with {', '.join(rung.effects)}" if rung.effects else "calibrated model",
            word=judged(rung.verdict or "", report.verdict),
            reason=rung.reason,
            rows=by_gain(rung.ranking or (found.ranking if index == 0 else ())),
        )
        for index, rung in enumerate(rungs)
    ]


def naming(report: GapReport) -> list[Ranking]:
    """The first ranking, and those of later rungs that brought an effect of the answer; that effect comes first."""
    found = report.judged
    if not found.rungs:
        return [replace(each, rows=found.ranking) for each in rankings(report)]
    told = []
    for index, (each, rung) in enumerate(zip(rankings(report), found.rungs, strict=True)):
        brought = {*rung.chosen, *rung.on_trial} & {*report.added}
        if index == 0 or brought:
            told.append(replace(each, rows=tuple(sorted(each.rows, key=lambda row: _standing(row, brought)))))
    return told


def _standing(row: CandidateEntry, brought: Collection[str]) -> tuple[bool, bool, bool, bool]:
    """What the answer speaks of comes first, then what stands; behind the rest what few windows or none tried."""
    return row.label not in brought, row.status not in STANDING, not row.fitted, not row.final


def by_gain(ranking: Sequence[CandidateEntry]) -> tuple[CandidateEntry, ...]:
    """Fitted candidates by the share that they remove, largest first, then the others by what they promise."""
    return tuple(sorted(ranking, key=lambda row: (not row.fitted, -(_shown(row) or 0.0))))


def _shown(row: CandidateEntry) -> float | None:
    return row.gain if row.fitted else row.predicted_gain
