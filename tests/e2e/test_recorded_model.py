"""From a model of one's own choice to logs, and from the logs to the floor of their noise, at the real command."""

import json
import subprocess
import sys
from pathlib import Path

PROGRAM = Path(sys.executable).with_name("dr-lab")
TRUTH = ["model=furuta", "peaks={motor:6}", "context={arm.mass:0.1}"]
SAME = ["model=furuta", "model.parameters.arm.mass.low=0.09", "windows.max_windows=4"]


def dr_lab(folder: Path, *arguments: str) -> str:
    done = subprocess.run([PROGRAM, *arguments], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_calibration_finds_the_recorded_mass(tmp_path: Path) -> None:
    dr_lab(tmp_path, "record", "source=model", *TRUTH, "output=logs", "duration=3", "shares=[1,0.8,0.9]")
    out = dr_lab(tmp_path, "fit", "--config-dir=logs", "measurements=recorded", *SAME, "hydra.run.dir=run")
    report = json.loads((tmp_path / "run" / "report.json").read_text(encoding="utf-8"))
    calibrated = report["ladder"][-1]
    mass = calibrated["parameters"]["arm.mass"]
    assert report["as_given"]["held_out"]["chi2"] > 2.0
    assert calibrated["held_out"]["chi2"] < 1.2
    assert abs(mass["value"] - 0.1) < 4 * mass["std"] < 0.002
    assert "Run folder: run" in out
