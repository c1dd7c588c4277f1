"""From a robot's description and logs to a right verdict, in two commands, as a new user types them."""

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from bags import write_bag
from own_robot import FRICTION, JOINTS, MJCF, URDF, Motion, write_csv

from dr_lab.__main__ import main
from dr_lab.trajectory import Array


def table(motion: Motion) -> Mapping[str, Array]:
    """Columns in another order than the robot's joints, in degrees and mN·m, the elbow turned."""
    (q1, q2), (u1, u2) = np.rad2deg(motion.position).T, 1e3 * motion.torque.T
    return {
        "t_ms": 1e3 * motion.time,
        "elbow_angle": -q2,
        "shoulder_angle": q1,
        "elbow_torque": -u2,
        "shoulder_torque": u1,
    }


@pytest.mark.slow
@pytest.mark.parametrize("form", ["a URDF and tables", "an MJCF and bags"])
def test_two_commands_name_the_friction_of_the_elbow(
    form: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("two.urdf").write_text(URDF)
    Path("two.xml").write_text(MJCF)
    motions = [Motion(seed, 8.0) for seed in range(4)]
    if form == "a URDF and tables":
        robot = "two.urdf"
        logs = [write_csv(Path(f"logs/log_{k}.csv"), table(motion)) for k, motion in enumerate(motions)]
    else:
        robot = "two.xml"
        logs = [
            write_bag(Path(f"run_{k}"), JOINTS, m.time, m.position, command=m.torque) for k, m in enumerate(motions)
        ]
    assert main(["init", robot, *map(str, logs)]) == 0
    assert main(["close", "--config-dir", "mine", "model=two", "measurements=two", "hydra.run.dir=run"]) == 0
    report = json.loads(Path("run/report.json").read_text(encoding="utf-8"))
    assert (report["verdict"], report["ladder"][-1]["effects"]) == ("named", ["soft_friction@elbow"])
    torque = report["ladder"][1]["parameters"]["soft_friction@elbow.torque"]
    assert torque["value"] == pytest.approx(FRICTION, rel=0.01)
    assert report["ladder"][1]["held_out"]["chi2"] < 1.1
