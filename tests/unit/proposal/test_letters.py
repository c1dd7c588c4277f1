"""Single letters at the end of names: units, or what tells one joint from others."""

from pathlib import Path
from typing import Any

import pytest
import yaml
from own_robot import MJCF, plain_logs

from dr_lab.__main__ import main
from dr_lab.proposal.words import read_name, told_apart


@pytest.mark.parametrize(
    ("name", "kind", "unit", "joint"),
    [
        ("theta_m", "position", "", "m"),
        ("q_a", "position", "", "a"),
        ("position_a", "position", "", "a"),
        ("angle_n", "position", "", "n"),
        ("enc_v", "position", "", "v"),
        ("tau_m", "drive", "", "m"),
        ("torque_a", "drive", "", "a"),
        ("motor_torque_v", "drive", "", "v"),
        ("u_m", "drive", "", "m"),
        ("speed_m", "velocity", "", "m"),
        ("cart_position_m", "position", "m", "cart"),
        ("tip_x_m", "position", "m", "tip"),
        ("motor_1_m", "position", "m", ""),
        ("slide_m", "position", "m", "slide"),
        ("u_a", "drive", "A", ""),
        ("i_q_a", "drive", "A", "i"),
        ("i_q", "drive", "", "i"),
        ("axis_i_q1", "drive", "", "axis"),
        ("q_i", "position", "", "i"),
        ("current_q_a", "drive", "A", ""),
        ("motor_v", "drive", "V", ""),
        ("rail_force_n", "drive", "N", "rail"),
        ("force_x_n", "drive", "N", "x"),
        ("rope_mrad", "position", "mrad", "rope"),
        ("gimbal_rate_mrad_s", "velocity", "mrad/s", "gimbal"),
    ],
)
def test_a_letter_is_a_unit_only_of_the_quantity_before_it(name: str, kind: str, unit: str, joint: str) -> None:
    words = read_name("", name, "")
    assert (words.kind, words.unit) == (kind, unit)
    assert not joint or joint in words.identity
    assert not unit or unit.lower() not in words.identity


@pytest.mark.parametrize(
    ("names", "units"),
    [
        (("q_m", "q_l"), ("", "")),
        (("arm_x_m_1", "arm_x_l_1"), ("", "")),
        (("pos_m", "pos_x"), ("m", "")),
        (("slide_m", "slide_f"), ("m", "")),
        (("q_m", "angle_l"), ("m", "")),
    ],
)
def test_a_letter_beside_another_one_is_no_unit(names: tuple[str, ...], units: tuple[str, ...]) -> None:
    apart = told_apart(names)
    assert tuple(read_name("", name, "", apart).unit for name in names) == units
    assert {read_name("", name, "", apart).kind for name in names[:1]} == {"position"}


def test_joints_that_a_letter_tells_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("two.xml").write_text(MJCF.replace('"shoulder"', '"a"').replace('"elbow"', '"b"'))
    logs = plain_logs(Path("logs"))
    for log in logs:
        log.write_text("time,q_a,torque_a,q_b,torque_b\n" + log.read_text().partition("\n")[2])
    assert main(["init", "two.xml", *map(str, logs)]) == 0
    found: dict[str, Any] = yaml.safe_load(Path("mine/measurements/two.yaml").read_text(encoding="utf-8"))
    assert found["outputs"] == {f"{joint}.position": {"column": f"q_{joint}", "unit": "rad"} for joint in "ab"}
    assert found["commands"] == {joint: {"column": f"torque_{joint}", "unit": "N·m"} for joint in "ab"}
