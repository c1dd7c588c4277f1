"""Longer windows are tried where shorter ones leave a gap unexplained, and believed where they name something."""

from dataclasses import dataclass, replace
from typing import Any, cast

import pytest
from diagnosis_machines import evidence_settings, windows_settings

from dr_lab.diagnosis.ladder import Ladder
from dr_lab.diagnosis.settings import EvidenceSettings, WindowSettings
from dr_lab.errors import DataError
from dr_lab.workflows import climbing
from dr_lab.workflows.study import Study


@dataclass(frozen=True)
class Asked:
    evidence: EvidenceSettings
    room: float

    def study(self, windows: WindowSettings) -> Study:
        if windows.length > self.room:
            raise DataError("No log holds a window.")
        return study(windows, self)


@dataclass(frozen=True)
class Answer:
    """A ladder of which only the verdict is known."""

    kind: str
    steps: tuple[str, ...] = ()

    def verdict(self, settings: EvidenceSettings) -> str:
        del settings
        return self.kind

    def with_laws(self, *known: object) -> "Answer":
        del known
        return self


def study(windows: WindowSettings, asked: Asked) -> Study:
    @dataclass(frozen=True)
    class Made:
        windows: WindowSettings
        asked: Asked
        bench: Any
        scales: Any = None
        compiled: Any = None

    bench = cast(Any, type("Bench", (), {"evidence": asked.evidence}))
    return cast(Study, Made(windows, asked, bench))


NOTHING, NAMED = Answer("unexplained"), Answer("named", ("friction",))


@pytest.mark.parametrize(
    ("answers", "room", "length", "kind"),
    [
        ([NAMED], 9.0, 0.3, "named"),
        ([Answer("none")], 9.0, 0.3, "none"),
        ([NOTHING, NAMED], 9.0, 0.9, "named"),
        ([NOTHING, NOTHING, NAMED], 9.0, 2.7, "named"),
        ([NOTHING, NOTHING, NOTHING], 9.0, 0.3, "unexplained"),
        ([NOTHING, Answer("none"), NOTHING], 9.0, 0.3, "unexplained"),  # a gap is not gone in longer windows
        ([NOTHING, NAMED], 0.5, 0.3, "unexplained"),  # the logs have no room for them
    ],
)
def test_the_shortest_windows_that_explain_the_gap(
    monkeypatch: pytest.MonkeyPatch, answers: list[Answer], room: float, length: float, kind: str
) -> None:
    left, confidence = iter(answers), list[float]()

    def climb(made: Study, *known: object) -> Ladder:
        del known
        confidence.append(made.bench.evidence.confidence)
        return cast(Ladder, next(left))

    monkeypatch.setattr(climbing, "_ladder", climb)
    asked = Asked(evidence_settings(confidence=0.97), room)
    first = study(replace(windows_settings(), length=0.3, longest=2.7), asked)
    found, ladder = climbing.climbed(first, {}, most=1, watch=lambda _: lambda _: None, phase=lambda _: None)
    assert found.windows.length == pytest.approx(length)
    assert ladder.verdict(asked.evidence) == kind
    assert confidence == pytest.approx([0.97, 0.99, 0.99][: len(confidence)])  # Bonferroni over three lengths
