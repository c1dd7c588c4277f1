"""The example that a newcomer copies, asked with the whole catalogue, gives the answer that `docs/start.md` shows."""

import json
from pathlib import Path

import pytest

from dr_lab.__main__ import main

ROBOT = Path(__file__).parents[2] / "examples" / "own_robot"
TRUTH = {  # make_logs.py
    "coulomb_friction@elbow.torque": 0.05,
    "upper.mass": 0.86,
    "lower.mass": 0.37,
    "shoulder.damping": 0.06,
    "elbow.damping": 0.015,
}


@pytest.mark.slow
def test_dry_friction_alone_is_named_with_its_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROBOT)
    words = ["--config-dir", "mine", "model=rig", "measurements=rig", f"hydra.run.dir={tmp_path / 'run'}"]
    assert main(["close", *words]) == 0
    report = json.loads((tmp_path / "run" / "report.json").read_text(encoding="utf-8"))
    assert report["verdict"] == "named"
    assert report["ladder"][-1]["effects"] == ["coulomb_friction@elbow"]
    assert report["remaining"]["status"] == "at_floor"
    found = report["ladder"][-1]["parameters"]
    assert set(found) == set(TRUTH)
    for name, true in TRUTH.items():
        assert abs(found[name]["value"] - true) < 2 * found[name]["std"], name
