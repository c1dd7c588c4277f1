"""What a report says first where a model predicts worse than the given one, diverges, or was learned."""

from typing import Any

import pytest

from dr_lab.reports.gap import GapReport
from dr_lab.reports.markdown import report_markdown
from dr_lab.reports.plain import from_plain

WORSE = "The calibrated model predicts the held-out logs worse than the model as given: χ² 355 → 34110. Do not use it."


def page(report: dict[str, Any]) -> str:
    return report_markdown(from_plain(GapReport, report))


def calibrated_to(report: dict[str, Any], chi2: float | None, status: str = "unexplained", **more: int) -> str:
    """The page's first line below its title, of a calibration that ends at that χ²."""
    rung = report["ladder"][0] | {"held_out": report["ladder"][0]["held_out"] | {"chi2": chi2}}
    fit = {
        "verb": "fit",
        "verdict": None,
        "ladder": [rung],
        "ranking": [],
        "remaining": {"status": status, "chi2": chi2},
    }
    report["as_given"]["held_out"] |= more
    return page(report | fit).splitlines()[2]


def test_a_calibration_that_predicts_worse_says_so_first(close_report: dict[str, Any]) -> None:
    line = calibrated_to(close_report, 3.411e4)
    assert line == f"**{WORSE}** What remains (χ² 34110) is above the noise floor and not explained."
    assert "worse than the model as given: χ² 355 → –." in calibrated_to(close_report, None)


def test_windows_that_diverge_are_told_with_what_remains(close_report: dict[str, Any]) -> None:
    close_report["ladder"][-1]["held_out"]["infeasible_windows"] = 7
    close_report |= {"verdict": "unexplained", "remaining": {"status": "unexplained", "chi2": 1.0}}
    line = page(close_report).splitlines()[2]
    assert "The simulation diverges in 7 of the windows that score. What remains (χ² 1) is above the noise" in line


@pytest.mark.parametrize(
    ("chi2", "status", "more"),
    [
        (355.01, "unexplained", {}),  # the same as printed
        (356.0, "at_floor", {}),  # noise
        (356.0, "unexplained", {"infeasible_windows": 1}),  # of more windows, the hardest among them
        (354.0, "unexplained", {}),
    ],
)
def test_what_is_no_worse_is_not_called_so(
    close_report: dict[str, Any], chi2: float, status: str, more: dict[str, int]
) -> None:
    line = calibrated_to(close_report, chi2, status, **more)
    assert line.startswith("**Calibrated on the logs.** χ² on held-out logs: 355 (model as given) → 35")


def test_effects_beside_a_bad_calibration_are_told_after_that_the_model_got_worse(close_report: dict[str, Any]) -> None:
    close_report["ladder"][1]["held_out"]["chi2"] = 400.0
    close_report |= {"verdict": "unexplained", "remaining": {"status": "unexplained", "chi2": 400.0}}
    line = page(close_report).splitlines()[2]
    assert line.startswith("**The model with `coulomb_friction@arm` predicts the held-out logs worse than the model as")
    assert "χ² 355 → 400. Do not use it.** **Unexplained:** `coulomb_friction@arm` closes" in line


def test_a_learned_force_that_nothing_could_judge_is_not_called_in_vain(close_report: dict[str, Any]) -> None:
    close_report["learned"] = [
        {
            "joint": "arm",
            "effect": "residual_force@arm",
            "depends_on": ["angle of arm"],
            "accepted": False,
            "removes": 0.8,
            "predicted": {"swing_01": [4.0, 2.0]},
        }
    ]
    assert "was tried, and does not predict" in page(close_report)
    close_report["learned"][0]["chi2"] = [6.1, 14.2]
    assert "was tried, and leaves more of the held-out logs than no force does, χ² 6.1 → 14.2 (" in page(close_report)
    close_report["learned"][0]["chi2"] = [14.2, 6.1]
    close_report["ladder"].append(close_report["ladder"][-1] | {"effects": ["residual_force@arm"], "learned": True})
    text = page(close_report)
    assert "**Learned in vain:** `residual_force@arm`" in text
    assert "is in the model as you asked, but does not predict" in text
    close_report["logs"]["held_out"] = []
    text = page(close_report)
    assert "in vain" not in text
    assert "**Learned, not judged:** `residual_force@arm`" in text
