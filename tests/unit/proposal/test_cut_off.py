"""Commands that a model cuts off, as a URDF's effort does, are told."""

from pathlib import Path

import numpy as np
import pytest
from own_robot import URDF, Motion, write_csv

from dr_lab.__main__ import main


def test_a_torque_beyond_the_effort_of_a_joint_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    motions = [Motion(seed) for seed in range(3)]
    peak = max(float(np.abs(motion.torque[:, 0]).max()) for motion in motions)
    Path("two.urdf").write_text(URDF.replace('effort="20"', f'effort="{0.8 * peak:.3f}"', 1))
    logs = []
    for seed, motion in enumerate(motions):
        places = {f"q{j + 1}": motion.position[:, j] for j in range(2)}
        torques = {f"tau{j + 1}": motion.torque[:, j] for j in range(2)}
        logs.append(str(write_csv(Path(f"logs/{seed}.csv"), {"time": motion.time, **places, **torques})))
    assert main(["init", "two.urdf", *logs]) == 0
    page = capsys.readouterr().out
    assert "shoulder: its command asks for " in page
    assert f"of which the model's actuatorfrcrange lets {-0.8 * peak:.3g} … {0.8 * peak:.3g} through." in page
    assert "elbow: its command asks" not in page
