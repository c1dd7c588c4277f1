"""What a verb prints of its answer."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

from dr_lab.comparison.finish import Run, answer, rest, save
from dr_lab.html.gap_page import write_gap_page
from dr_lab.recorders.look import Look
from dr_lab.reports.gap import GapReport
from dr_lab.reports.gap_entries import NoteEntry
from dr_lab.reports.markdown import report_markdown
from dr_lab.reports.plain import from_plain
from dr_lab.reports.quantity import percent

DOUBT = "only 2 logs are fitted; from 3 on (evidence.least_trusted) their scatter is known"


def report(close_report: dict[str, Any]) -> GapReport:
    last = close_report["ladder"][-1]
    last["fit"] = {"converged": True, "iterations": 4, "windows": 8, "infeasible_windows": 0}
    last["parameters"]["pole.mass"] |= {"cv_percent": 0.3, "doubts": [DOUBT]}
    return from_plain(GapReport, close_report)


def test_intervals_that_are_not_to_be_trusted_are_printed(
    close_report: dict[str, Any], look: Look, tmp_path: Path
) -> None:
    shown: list[str] = []
    screen = SimpleNamespace(show=shown.append)
    answer(report(close_report), Run(tmp_path, look, cast(Any, screen)))
    told = f"Do not trust the intervals of `pole.mass`: {DOUBT}."
    assert told in "\n".join(shown)
    write_gap_page(tmp_path / "report.html", report(close_report), [], look)
    assert DOUBT in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_faults_come_first_and_are_not_told_in_full_again(
    close_report: dict[str, Any], look: Look, tmp_path: Path
) -> None:
    close_report["notes"].append(
        {"kind": "fault", "fault": "sign", "log": "swing_05", "signal": "motor", "message": "Turned."}
    )
    shown: list[str] = []
    answer(report(close_report), Run(tmp_path, look, cast(Any, SimpleNamespace(show=shown.append))))
    told = "**The logs seem faulty:** sign motor (1 log). Mend this first: what follows may come of it. **The missing"
    assert shown[0].startswith(told)
    assert "Turned." not in shown[0]
    page = tmp_path / "report.html"
    write_gap_page(page, report(close_report), [], look)
    assert "Mend this first" in page.read_text(encoding="utf-8").split("The missing effect is named")[0]


def searched(effect: str) -> NoteEntry:
    return NoteEntry(f"{effect}: of 1 to 120 periods …", "searched_periods", effect=effect)


def test_notes_on_rejected_candidates_stand_last_and_in_the_file_alone(
    close_report: dict[str, Any], look: Look, tmp_path: Path
) -> None:
    """The periods of a candidate that is not in the answer concern nobody who reads the screen."""
    rejected, added = searched("cogging@arm"), searched("coulomb_friction@arm")
    told = replace(report(close_report), notes=(rejected, added, NoteEntry("swing_05: cut.", "gap", log="swing_05")))
    run = Run(tmp_path, look, cast(Any, SimpleNamespace(show=lambda _: None)))
    save(told, run)
    written = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))["notes"]
    assert [note.get("effect") for note in written] == ["coulomb_friction@arm", None, "cogging@arm"]
    shown = rest(replace(told, notes=(added, rejected)))
    assert "coulomb_friction@arm: of 1 to 120" in shown
    assert "cogging@arm" not in shown
    assert "… and 1 more in report.md" in shown


def test_what_the_written_model_lacks_comes_first_and_how_files_were_read_last(
    close_report: dict[str, Any], look: Look, tmp_path: Path
) -> None:
    kinds = ("separator", "time_step", "export", "encoding")
    told = replace(report(close_report), notes=tuple(NoteEntry(f"{kind}.", kind) for kind in kinds))
    save(told, Run(tmp_path, look, cast(Any, SimpleNamespace(show=lambda _: None))))
    written = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))["notes"]
    assert [note["kind"] for note in written] == ["export", "time_step", "separator", "encoding"]


def test_the_screen_and_the_file_tell_the_same_share_of_failure(close_report: dict[str, Any]) -> None:
    """38 % of the squared error is another part of the error itself."""
    told = report(close_report)
    row = told.failing.where[0]
    said = f"{row.region}: {percent(row.share)} of its squared error"
    assert said in rest(told)
    assert said in report_markdown(told)


def test_each_added_effect_has_its_row_beside_the_model_that_it_was_added_to(
    close_report: dict[str, Any], look: Look, tmp_path: Path
) -> None:
    """The second effect of a ladder is not among the first candidates of the first ranking."""
    first, second = (dict(close_report["ranking"][k]) for k in (0, 2))
    close_report["ladder"].append(
        close_report["ladder"][-1] | {"effects": ["coulomb_friction@arm", "quadratic_drag@arm"]}
    )
    close_report["rungs"] = [
        {"verdict": "named", "reason": "", "chosen": ["coulomb_friction@arm"], "ranking": [first]},
        {
            "verdict": "named",
            "reason": "",
            "effects": ["coulomb_friction@arm"],
            "chosen": ["quadratic_drag@arm"],
            "ranking": [*close_report["ranking"][3:], second | {"status": "named"}],
        },
        {"verdict": "none", "reason": "", "effects": ["coulomb_friction@arm", "quadratic_drag@arm"], "ranking": []},
    ]
    shown: list[str] = []
    answer(report(close_report), Run(tmp_path, look, cast(Any, SimpleNamespace(show=shown.append))))
    before, later = shown[0].split("Beside the model with coulomb_friction@arm:\n\n")
    assert "Beside the calibrated model:\n\n| effect" in before
    assert later.splitlines()[2].startswith("| `quadratic_drag@arm` | named | 9.8 |")
    assert "… and 1 more in report.md." in later
