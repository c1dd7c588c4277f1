"""The notebooks of examples/ run as they are, in a folder of their own, and find what is hidden."""

import json
import runpy
import shutil
from pathlib import Path
from typing import Any

import pytest

from dr_lab.__main__ import main

EXAMPLES = Path(__file__).parents[2] / "examples"


def run(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    monkeypatch.chdir(folder)
    return runpy.run_path(str(EXAMPLES / f"{name}.py"))


@pytest.mark.slow
def test_own_robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    report = run("own_robot", tmp_path, monkeypatch)["report"]
    assert report.ladder[-1].effects == ("coulomb_friction@elbow",)
    found = {name: entry.value for name, entry in report.ladder[-1].parameters.items()}
    truth = {"upper.mass": 0.86, "lower.mass": 0.37, "shoulder.damping": 0.06, "elbow.damping": 0.015}  # make_logs.py
    assert found == pytest.approx({**truth, "coulomb_friction@elbow.torque": 0.05}, rel=0.02)


@pytest.mark.slow
def test_the_time_step_of_another_simulator_is_no_law(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With 0.5 ms steps the machine differs by three times its noise, which a Stribeck curve takes up in part."""
    copied = shutil.copytree(EXAMPLES / "own_robot", tmp_path / "robot")
    script = copied / "make_logs.py"
    text = script.read_text(encoding="utf-8")
    assert "STEPS = 64 " in text
    script.write_text(text.replace("STEPS = 64 ", "STEPS = 8 "), encoding="utf-8")
    runpy.run_path(str(script), run_name="__main__")
    monkeypatch.chdir(copied)
    assert main(["close", "--config-dir", "mine", "model=rig", "measurements=rig", "hydra.run.dir=closed"]) == 0
    last = json.loads(Path("closed/report.json").read_text(encoding="utf-8"))["ladder"][-1]
    assert last["effects"] == ["coulomb_friction@elbow"]
    assert last["parameters"]["coulomb_friction@elbow.torque"]["value"] == pytest.approx(0.05, rel=0.02)


@pytest.mark.slow
def test_hidden_effect(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    report = run("hidden_effect", tmp_path, monkeypatch)["report"]
    assert report.verdict == "named"
    assert report.judged.ranking[0].label == "coulomb_friction@pendulum"


@pytest.mark.slow
def test_from_gap_to_policy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    left = run("from_gap_to_policy", tmp_path, monkeypatch)
    assert left["closed"].ladder[-1].effects == ("actuator_delay@motor",)
    figures = left["played"].figures
    assert figures["real"] > 250  # of at most 300; some 20 where the delay is not known
    assert figures["real"] == pytest.approx(figures["simulated"], rel=0.05)
