"""Cosines between the gradients of contexts, over the runs of a pretended sweep."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rerun as rr
from html_pages import text, traces, values
from written_runs import grid_report, write_run

from dr_lab.__main__ import main
from dr_lab.errors import DataError
from dr_lab.recorders.interference import Interference
from dr_lab.summaries.groups import grouped
from dr_lab.summaries.interferences import interferences
from dr_lab.summaries.runs import find_runs

MASSES = [1.0, 2.0, 4.0]


def evaluated(
    folder: Path, cosines: dict[int, list[float | None]], *overrides: str, masses: list[float] = MASSES
) -> None:
    """An evaluation: by the control steps of a policy, cosines of the pairs 1–2, 1–4 and 2–4; 0.9 on the diagonal."""
    rows: list[dict[str, Any]] = []
    for frames, (one_two, one_four, two_four) in cosines.items():
        upper = {(0, 0): 0.9, (0, 1): one_two, (0, 2): one_four, (1, 1): 0.9, (1, 2): two_four, (2, 2): 0.9}
        for (a, b), cosine in upper.items():
            sign = 0.0 if a != b and cosine is not None and abs(cosine) < 0.25 else 1.0
            rows.append(
                {"frames": float(frames), "mass a": masses[a], "mass b": masses[b], "cosine": cosine, "sign": sign}
            )
    report = grid_report(rows, {"mass a": "kg", "mass b": "kg"}) | {"evaluator": "GradientInterferenceEvaluator"}
    write_run(folder, report | {"figures": {"helping": 0.5}}, *overrides)


def found_in(folder: Path) -> list[Interference]:
    return interferences(grouped(find_runs(folder)[0], ["seed"]), 0.95)


def test_cells_are_means_of_the_runs_with_their_spread(tmp_path: Path) -> None:
    evaluated(tmp_path / "0", {100: [0.1, 0.2, 0.3], 200: [0.5, -0.5, 0.2]}, "order=low", "seed=0")
    evaluated(tmp_path / "1", {104: [0.3, 0.2, 0.3], 204: [0.7, -0.7, -0.2]}, "order=low", "seed=1")
    evaluated(tmp_path / "2", {102: [0.2, 0.2, None], 202: [0.6, -0.6, 0.0]}, "order=low", "seed=2")
    evaluated(tmp_path / "3", {100: [0.3, 0.2, 0.3]}, "order=high", "seed=0")
    early, late, other = found_in(tmp_path)
    assert [(each.group, each.runs, each.frames) for each in (early, late, other)] == [
        ("low", 3, 102),
        ("low", 3, 202),
        ("high", 1, 100),
    ]
    np.testing.assert_allclose(early.mean, [[0.9, 0.2, 0.2], [0.2, 0.9, 0.3], [0.2, 0.3, 0.9]])
    np.testing.assert_allclose(early.spread, [[0, 0.1, 0], [0.1, 0, 0], [0, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(late.mean[0], [0.9, 0.6, -0.6])
    np.testing.assert_allclose(late.spread[1], [0.1, 0.0, 0.2], atol=1e-12)
    # ± t(0.975, 2) 0.1/√3 = 0.25 leaves the sign of 0.6 sure, that of 0.2 and of 0 in doubt.
    assert early.doubtful.tolist() == [[False, True, False], [True, False, False], [False, False, False]]
    assert late.doubtful[1].tolist() == [False, False, True]
    assert np.isnan(other.spread).all()
    assert other.doubtful[0].tolist() == [False, False, True]  # as its evaluation says
    assert other.axis.values.tolist() == MASSES


def test_the_last_policies_go_together(tmp_path: Path) -> None:
    evaluated(tmp_path / "0", {100: [0.1, 0.2, 0.3], 200: [0.2, 0.2, 0.2], 300: [0.4, 0.4, 0.4]}, "seed=0")
    evaluated(tmp_path / "1", {210: [0.4, 0.2, 0.2], 290: [0.4, 0.4, 0.4]}, "seed=1")
    early, late = found_in(tmp_path)
    assert (early.frames, late.frames) == (205, 295)
    assert early.mean[0, 1] == pytest.approx(0.3)


def test_evaluations_over_other_contexts_are_not_averaged(tmp_path: Path) -> None:
    evaluated(tmp_path / "0", {100: [0.1, 0.2, 0.3]}, "seed=0")
    evaluated(tmp_path / "1", {100: [0.1, 0.2, 0.3]}, "seed=1", masses=[1.0, 2.0, 3.0])
    with pytest.raises(DataError, match="was evaluated over other contexts than"):
        found_in(tmp_path)


def test_a_row_without_its_columns_is_told(tmp_path: Path) -> None:
    evaluated(tmp_path / "0", {100: [0.1, 0.2, 0.3]}, "seed=0")
    report = json.loads((tmp_path / "0/report.json").read_text("utf-8"))
    for row in report["rows"]:
        del row["cosine"]
    (tmp_path / "0/report.json").write_text(json.dumps(report), "utf-8")
    with pytest.raises(DataError, match=r"report\.json: a row lacks 'cosine'"):
        found_in(tmp_path)


def test_the_verb_tells_and_draws_it(tmp_path: Path) -> None:
    for seed in range(2):
        evaluated(
            tmp_path / f"sweep/{seed}", {100: [0.5, -0.5, 0.5], 200: [0.5, 0.5, 0.5]}, "order=low", f"seed={seed}"
        )
        evaluated(tmp_path / f"sweep/{10 + seed}", {200: [-0.5, -0.5, None]}, "order=high", f"seed={seed}")
    folder = tmp_path / "summary"
    assert main(["summarize", f"sweep={tmp_path / 'sweep'}", f"hydra.run.dir={folder}"]) == 0
    page = (folder / "report.md").read_text("utf-8")
    assert "| low | 100 | 2 | 3 | 0.167 | 0 | 33 % | 67 % | 0 % |" in page
    assert "| high | 200 | 2 | 3 | -0.5 | 0 | 100 % | 0 % | 0 % |" in page
    entries = json.loads((folder / "report.json").read_text("utf-8"))["interference"]
    assert [(entry["group"], entry["frames"], entry["mean"][0]) for entry in entries] == [
        ("low", 100, [0.9, 0.5, -0.5]),
        ("low", 200, [0.9, 0.5, 0.5]),
        ("high", 200, [0.9, -0.5, -0.5]),
    ]
    written = (folder / "report.html").read_text("utf-8")
    assert "low: cosines between policy gradients, mean of 2 runs. Standard deviation over the runs 0," in text(written)
    low, high = ([each for each in traces(written, name) if each["type"] == "heatmap"] for name in ("low", "high"))
    np.testing.assert_allclose([values(each["z"])[0] for each in low], [[0.9, 0.5, -0.5], [0.9, 0.5, 0.5]], rtol=1e-6)
    assert [each["xaxis"] for each in high] == ["x2"]  # the last policies of both stand below one another
    entities = {str(chunk.entity_path) for chunk in rr.chunk.RrdReader(folder / "review.rrd").stream()}
    assert {path.split("/")[2] for path in entities if path.startswith("/matrix/")} == {
        "100\\ steps\\,\\ low",
        "200\\ steps\\,\\ low",
        "200\\ steps\\,\\ high",
    }
