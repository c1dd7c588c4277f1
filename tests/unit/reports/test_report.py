import csv
import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from dr_lab.errors import DataError
from dr_lab.reports.gap import GapReport
from dr_lab.reports.plain import finite, from_plain, to_plain
from dr_lab.reports.report import write_report
from dr_lab.reports.schema import validate
from dr_lab.trajectory import Noise


def test_reports_follow_the_schema_and_read_back(
    tmp_path: Path, close_report: dict[str, Any], compare_report: dict[str, Any]
) -> None:
    for sample in (close_report, compare_report):
        report = from_plain(GapReport, sample)
        write_report(tmp_path, report)
        read = json.loads((tmp_path / "report.json").read_text("utf-8"))
        validate(read)
        assert sample.keys() <= read.keys()
        assert from_plain(GapReport, read) == report


def test_numpy_types_and_missing_numbers_become_json(tmp_path: Path, close_report: dict[str, Any]) -> None:
    rung = close_report["ladder"][0]["held_out"]
    rung["chi2"] = np.float32(0.5)
    rung["rmse"]["arm.position"] = np.inf
    rung["nrmse"] = {"arm.position": np.float64("nan")}
    close_report["ranking"][0]["gain_ci"] = np.array([0.93, np.nan])
    report = finite(from_plain(GapReport, close_report))
    assert report.judged.ranking[0].gain_ci == (0.93, None)
    write_report(tmp_path, report)
    text = (tmp_path / "report.json").read_text("utf-8")
    assert "NaN" not in text
    assert "Infinity" not in text
    read = json.loads(text)
    assert read["ladder"][0]["held_out"]["chi2"] == 0.5
    assert read["ladder"][0]["held_out"]["rmse"]["arm.position"] is None
    assert read["ladder"][0]["held_out"]["nrmse"] == {"arm.position": None}
    assert read["ranking"][0]["gain_ci"] == [0.93, None]
    assert to_plain({"noise": Noise(0.0015, "rad", "given"), "file": Path("a.csv")}) == {
        "noise": dataclasses.asdict(Noise(0.0015, "rad", "given")),
        "file": "a.csv",
    }
    validate(read)


def test_metrics_have_a_row_for_each_model_and_channel(tmp_path: Path, close_report: dict[str, Any]) -> None:
    write_report(tmp_path, from_plain(GapReport, close_report))
    with (tmp_path / "metrics.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    models = ["model as given", "calibrated", "+ coulomb_friction@arm"]
    assert [(row["model"], row["channel"]) for row in rows] == [
        (model, channel) for model in models for channel in ("arm.position", "pole.position")
    ]
    last = rows[-1]
    assert (last["effects"], last["unit"]) == ("coulomb_friction@arm", "rad")
    assert float(last["chi2"]) == 1.003
    assert float(last["rmse_predicted"]) == 0.00152
    assert float(last["fit_percent"]) == 99.1
    assert last["nrmse"] == ""  # not in this report


def test_unstorable_value_names_its_place() -> None:
    with pytest.raises(DataError, match=r"report\.ladder\[0\]\.chi2 is a complex"):
        to_plain({"ladder": [{"chi2": 1j}]})


def test_validator_lists_every_problem(close_report: dict[str, Any]) -> None:
    del close_report["noise"]
    close_report["verdict"] = "perhaps"
    close_report["ladder"][1]["held_out"]["chi2"] = "1"
    close_report["ladder"][1]["effects"] = ["coulomb_friction"]
    del close_report["ranking"][2]["gain"]
    with pytest.raises(DataError) as error:
        validate(close_report)
    with pytest.raises(DataError, match="The report holds a list; expected a JSON object"):
        validate([])
    for place in (
        "'noise' is a required",
        "$.verdict",
        "$.ladder[1].held_out.chi2",
        "$.ladder[1].effects",
        "$.ranking[2]",
    ):
        assert place in str(error.value)
