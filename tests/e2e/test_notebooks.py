"""The notebooks of examples/ run as they are, in a folder of their own, and find what is hidden."""

import runpy
from pathlib import Path
from typing import Any

import pytest

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
