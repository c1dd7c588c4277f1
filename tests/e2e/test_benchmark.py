"""The verb from the command line: what it is told, what it leaves, and how it goes on."""

import json
import re
from pathlib import Path

import pytest

from dr_lab.__main__ import main

DIAGNOSE = (
    "model=furuta",
    "measurements=furuta",
    "windows.seconds=4.8",
    "effect=[coulomb_friction,actuator_delay]",
)
SMALL = "machines.furuta.diagnose=[" + ",".join(f'"{override}"' for override in DIAGNOSE) + "]"
CASES = [
    "~cases.coarse",
    "~cases.several",
    "~cases.outside",
    "cases.single.hidden={furuta:[furuta/coulomb_friction_arm]}",
]
FILES = {
    "benchmark.json",
    "report.md",
    "report.html",
    "cases.csv",
    "confusion.csv",
    "confusion.png",
    "review.rrd",
    "config.yaml",
    "cases",
}


def test_help_names_the_presets(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["benchmark", "--help"]) == 0
    out = capsys.readouterr().out
    assert re.search(r"^ +quick +a few cases", out, re.MULTILINE)
    assert re.search(r"^ +full +everything", out, re.MULTILINE)
    assert re.search(r"^ +strangers +machines by another engine", out, re.MULTILINE)
    assert "  machine=all   several at once" in out


def test_what_cannot_be_resumed_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    few = ["machine=furuta", "effect=spring"]
    assert main(["benchmark", *few, f"resume={tmp_path}", f"hydra.run.dir={tmp_path / 'run'}"]) == 2
    assert "is no run folder of a benchmark" in capsys.readouterr().err


@pytest.mark.slow
def test_a_run_and_its_resumption(tmp_path: Path) -> None:
    first, again = tmp_path / "first", tmp_path / "again"
    line = ["benchmark", "machine=furuta", *CASES, SMALL]
    assert main([*line, f"hydra.run.dir={first}"]) == 0
    assert {path.name for path in first.iterdir()} == FILES
    found = json.loads((first / "benchmark.json").read_text())
    assert found["cases"] == 2
    assert found["rates"]["top_1"]["share"] == 1.0
    assert found["rates"]["false_alarm"]["count"] == 0
    assert found["medians"]["median_parameter_error"] < 0.02
    (first / "cases" / "furuta-none-encoders-0.json").unlink()
    assert main([*line, f"resume={first}", f"hydra.run.dir={again}"]) == 0
    resumed = json.loads((again / "benchmark.json").read_text())
    for result in (found, resumed):
        for part in (result, *result["machines"].values()):
            part["medians"] = {k: v for k, v in part["medians"].items() if not k.endswith(("cpu", "wall"))}
    assert resumed == found
