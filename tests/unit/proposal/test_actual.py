"""Names of drives that also say what there is: act of actual, current of present."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from own_robot import URDF, Motion, write_csv

from dr_lab.__main__ import main
from dr_lab.proposal.words import asked_for, read_name


@pytest.mark.parametrize(("name", "unit"), [("pos_turns", "turn"), ("motor_pos_rev", "turn"), ("scale [µm]", "um")])
def test_units_of_positions(name: str, unit: str) -> None:
    assert (read_name("", name, "").kind, read_name("", name, "").unit) == ("position", unit)


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("pos_act_1", "position"),
        ("ActPos1", "position"),
        ("q_act", "position"),
        ("J1_act_deg", "position"),
        ("current_position", "position"),
        ("current_angle_2", "position"),
        ("vel_act", "velocity"),
        ("torque_act", "drive"),
        ("act_1", "drive"),
        ("current_q", "drive"),
        ("act_current", "drive"),
        ("pos_set_1", "reference"),
        ("SetPos", "reference"),
        ("q_soll", "reference"),
    ],
)
def test_what_is_said_of_a_position_is_one(name: str, kind: str) -> None:
    assert read_name("", name, "").kind == kind


def test_actual_is_no_actuator_beside_what_is_asked_for() -> None:
    asked = asked_for(["J1_des", "J1_act", "J2_act"])
    assert [read_name("", name, "", (), asked).kind for name in ("J1_des", "J1_act", "J2_act")] == [
        "reference",
        "",
        "drive",
    ]


@pytest.mark.parametrize(("name", "constant"), [("cur", 4.0), ("cur_mA", 1.05e-3)])
def test_currents_of_a_description_without_actuators_get_the_scale_that_the_motion_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, constant: float
) -> None:
    """Nothing says that they are torques, not even a torque constant that is nearly 1 mN·m/mA."""
    monkeypatch.chdir(tmp_path)
    Path("two.urdf").write_text(URDF)
    logs = [str(write_csv(Path(f"logs/{seed}.csv"), _columns(Motion(seed), name, constant))) for seed in range(3)]
    assert main(["init", "two.urdf", *logs]) == 0
    found = yaml.safe_load(Path("mine/measurements/two.yaml").read_text(encoding="utf-8"))
    assert {name: output["column"] for name, output in found["outputs"].items()} == {
        "shoulder.position": "J1_act",
        "elbow.position": "J2_act",
    }
    commands = [found["commands"][joint] for joint in ("shoulder", "elbow")]
    assert [each["column"] for each in commands] == [f"J1_{name}", f"J2_{name}"]
    assert [each["unit"] for each in commands] == ["N·m"] * 2
    assert [each["scale"] for each in commands] == pytest.approx([constant] * 2, rel=0.3)


def _columns(motion: Motion, name: str, constant: float) -> dict[str, Any]:
    asked, place, current = np.degrees(np.roll(motion.position, -9, 0)), np.degrees(motion.position), motion.torque
    named = {"des": asked, "act": place, name: current / constant}
    columns = {f"J{j + 1}_{kind}": values[:, j] for kind, values in named.items() for j in range(2)}
    return {"time": motion.time, **columns}
