"""Candidates stand in an order that their numbers bear out, beside what the noise leaves to remove."""

from typing import Any

import pytest

from dr_lab.reports.gap import GapReport
from dr_lab.reports.plain import from_plain
from dr_lab.reports.rankings import naming
from dr_lab.reports.tables import noise_included


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


@pytest.mark.parametrize(("chi2", "told"), [(2.0, "of 2 at most 50 % can go"), (84.0, ""), (0.98, "")])
def test_how_much_of_a_small_error_can_go_is_told(close_report: dict[str, Any], chi2: float, told: str) -> None:
    close_report["ladder"][0]["held_out"]["chi2"] = chi2
    note = noise_included(from_plain(GapReport, close_report))
    assert told in note
    assert bool(note) == bool(told)
