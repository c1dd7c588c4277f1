"""The first sentence of an evaluation: what the figures come to, in words that can be read aloud."""

import math

import pytest

from dr_lab.reports.evaluate import SCHEMA, EvaluateReport
from dr_lab.reports.evaluate_page import evaluate_page


@pytest.mark.parametrize(
    ("figures", "said"),
    [
        ({"mean_return": 281.0, "best_return": 309.0}, "Mean return 281, best return 309"),
        ({"uniform.iqm": 283.5, "uniform.worst_decile": 247.0}, "Uniform: iqm 283.5, worst decile 247"),
        ({"a.iqm": 1.0, "b.iqm": 2.0}, "A.iqm 1, b.iqm 2"),
        ({"real": 280.0, "real.low": 269.0, "real.high": 285.0, "solved": 1.0}, "Real 280 (269 … 285), solved 1"),
        ({"return_after_0": 279.0, "gain_1": 2.5}, "Return after 0: 279, gain 1: 2.5"),
        ({"iqm": 3.0, "low": 2.0, "high": 4.0}, "Iqm 3 (2 … 4)"),
        (
            {"a.eigenvalue": 9.0, "a.curvature": 5.0, "a.low": 1.0, "a.high": 8.0, "b.eigenvalue": -2.0},
            "A.eigenvalue 9, a.curvature 5 (1 … 8), b.eigenvalue -2",
        ),
    ],
)  # fmt: skip
def test_the_first_sentence(figures: dict[str, float], said: str) -> None:
    report = EvaluateReport(SCHEMA, "evaluate", "runs/swing", "hopper", "RealVsSimEvaluator", figures, (), "run")
    page = evaluate_page(report, "Told.", report.rows)
    assert page.lead == f"**{said}.** Told."
    assert page.title == "Real vs sim of swing on hopper"
    table = page.sections[0].body
    assert all(name.replace("_", " ") in table for name in figures)


def test_a_long_table_names_the_file_that_holds_all_of_it() -> None:
    rows = [{"domain": float(k), "upper_quartile": 10.0 * k, "arm_1.mass": 0.5} for k in range(45)]
    units = {"arm_1.mass": "kg"}
    report = EvaluateReport(SCHEMA, "evaluate", "runs/swing", "hopper", "unseen_domains", {}, (), "run", units)
    body = evaluate_page(report, "Told.", rows, "domains.csv").sections[1].body
    assert "| upper quartile | arm_1.mass [kg] |" in body
    assert "430" not in body
    assert "390" in body
    assert body.endswith("… and 5 more in domains.csv.")


def test_a_long_table_of_returns_shows_the_worst() -> None:
    rows = [{"mass": float(k), "return": math.nan if k == 20 else 100.0 - k} for k in range(42)]
    report = EvaluateReport(SCHEMA, "evaluate", "runs/swing", "hopper", "GridEvaluator", {}, (), "run")
    body = evaluate_page(report, "Told.", rows).sections[1].body
    assert [line.split()[1] for line in body.splitlines()[2:5]] == ["20", "41", "40"]  # diverged, then lowest return
    assert "| 0 |" not in body
    assert body.endswith("The 40 worst of 42, worst return first; returns.csv has all.")
    assert evaluate_page(report, "Told.", rows[:40]).sections[1].body.splitlines()[2].split()[1] == "0"  # in grid order


def test_counts_keep_all_their_digits() -> None:
    rows = [{"frames": 32768.0, "return": 281.7345}]
    figures = {"parameters": 13572.0}
    report = EvaluateReport(SCHEMA, "evaluate", "runs/swing", "hopper", "SnapshotsEvaluator", figures, (), "run")
    found, played = (section.body for section in evaluate_page(report, "Told.", rows).sections)
    assert "| parameters | 13572 |" in found
    assert "| 32768 | 281.7 |" in played
