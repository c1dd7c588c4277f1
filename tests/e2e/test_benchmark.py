"""The verb from the command line: what it is told, what it leaves, and how it goes on."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf
from pretended_cases import A, named

from dr_lab.__main__ import main
from dr_lab.benchmark.case import expand
from dr_lab.benchmark.pool import keep
from dr_lab.cli.compose import compose

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
    line = ["benchmark", "machine=furuta", "effect=spring", f"resume={tmp_path}", f"hydra.run.dir={tmp_path / 'run'}"]
    assert main(line) == 2
    assert "Give resume=FOLDER of a run of dr-lab benchmark" in capsys.readouterr().err
    OmegaConf.save(compose("benchmark", ["machine=furuta"]), tmp_path / "config.yaml")
    assert main(line) == 2
    assert "is no run folder of a benchmark" in capsys.readouterr().err


def test_answers_that_were_scored_by_other_classes_are_not_taken_over(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first, line = tmp_path / "first", ["benchmark", "machine=furuta", "effect=spring"]
    cfg = compose("benchmark", line[1:])
    sets, machines = (instantiate(cfg[key], _convert_="all") for key in ("cases", "machines"))
    case = next(case for case in expand(sets, machines) if case.kind == "single")
    (first / "cases").mkdir(parents=True)
    keep(first / "cases", {case: replace(named(A), case=case)})
    OmegaConf.save(cfg, first / "config.yaml")
    again = [*line, f"only=[{case.name}]", f"resume={first}"]
    assert main([*again, "goals=strangers", f"hydra.run.dir={tmp_path / 'again'}"]) == 0
    assert main([*again, "classes=predicted", f"hydra.run.dir={tmp_path / 'other'}"]) == 2
    assert "classes._target_ is dr_lab.benchmark.predicted.PredictedClasses, there" in capsys.readouterr().err


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
