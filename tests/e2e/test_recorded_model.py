"""From a model of one's own choice to logs, and from the logs to the floor of their noise."""

import json
import subprocess
import sys
from pathlib import Path

import mujoco
import pytest
from mcap.reader import make_reader

from dr_lab.__main__ import main

PROGRAM = Path(sys.executable).with_name("dr-lab")
TRUTH = ["model=furuta", "peaks={motor:6}", "context={arm.mass:0.1}"]
READ = ["model=furuta", "measurements=recorded", "windows.seconds=4.8"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with logs."""
    made = tmp_path_factory.mktemp("recorded")
    logs = ("duration=3", "shares=[1,0.8,0.9]", f"output={made}/logs")
    assert main(["record", "source=model", *TRUTH, *logs]) == 0
    return made


@pytest.mark.slow
def test_calibration_at_the_real_command_finds_the_recorded_mass(folder: Path) -> None:
    arguments = ["fit", "--config-dir=logs", *READ, "hydra.run.dir=fitted"]
    done = subprocess.run([PROGRAM, *arguments], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    report = json.loads((folder / "fitted" / "report.json").read_text(encoding="utf-8"))
    calibrated = report["ladder"][-1]
    mass = calibrated["parameters"]["arm.mass"]
    assert report["as_given"]["held_out"]["chi2"] > 2.0
    assert calibrated["held_out"]["chi2"] < 1.2
    assert abs(mass["value"] - 0.1) < 4 * mass["std"] < 0.002


@pytest.mark.slow
def test_comparison_leaves_a_folder_that_explains_itself(folder: Path) -> None:
    run = folder / "compared"
    assert main(["compare", f"--config-dir={folder}/logs", *READ, f"hydra.run.dir={run}"]) == 0
    files = {"config.yaml", "report.json", "report.md", "report.html", "metrics.csv", "review.rrd", "simulated.mcap"}
    assert {path.name for path in run.iterdir()} == files
    with (run / "simulated.mcap").open("rb") as file:
        attached = {part.name: part.data for part in make_reader(file).iter_attachments()}
    assert attached["config.yaml"] == (run / "config.yaml").read_bytes()
    assert mujoco.MjModel.from_xml_string(attached["model.xml"].decode()).joint("pole").id == 1
