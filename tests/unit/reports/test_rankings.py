"""The order in which a screen shows candidates is one that its numbers bear out."""

from typing import Any

from dr_lab.reports.gap import GapReport
from dr_lab.reports.plain import from_plain
from dr_lab.reports.rankings import naming


def test_where_nothing_stands_what_removes_most_is_shown_first_and_few_windows_last(
    close_report: dict[str, Any],
) -> None:
    like = {**close_report["ranking"][0], "status": "rejected", "final": True}
    gains = [("some", 0.1, True), ("promising", 0.9, False), ("most", 0.3, True)]
    ranking = [{**like, "effect": name, "gain": gain, "final": final} for name, gain, final in gains]
    rungs = [{"verdict": "unexplained", "reason": "none is", "ranking": ranking}]
    report = close_report | {"rungs": rungs, "verdict": "unexplained", "ladder": close_report["ladder"][:1]}
    first = naming(from_plain(GapReport, report))[0]
    assert [row.effect for row in first.rows] == ["most", "some", "promising"]
