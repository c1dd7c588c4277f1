"""`dr-lab init` on a robot of two joints whose logs hide which column is what, in which unit and direction."""

import itertools
import re
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml
from bags import write_bag
from own_robot import JOINTS, MJCF, PEAK, URDF, Motion, servo_log, write_csv

from dr_lab.__main__ import main
from dr_lab.trajectory import Array

DEGREES = 180 / np.pi
Columns = Callable[[Motion], Mapping[str, Array]]


@cache
def motions() -> tuple[Motion, ...]:
    return tuple(Motion(seed, seconds=4.0) for seed in range(3))


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("two.urdf").write_text(URDF)
    Path("two.xml").write_text(MJCF)
    return tmp_path


def write_logs(columns: Columns) -> list[str]:
    return [str(write_csv(Path(f"logs/log_{k}.csv"), columns(motion))) for k, motion in enumerate(motions())]


def proposed(robot: str, logs: list[str], *more: str) -> dict[str, Any]:
    """The written measurements."""
    assert main(["init", robot, *logs, *more]) == 0
    return yaml.safe_load(Path("mine/measurements/two.yaml").read_text(encoding="utf-8"))


def read_as(channel: Mapping[str, Any]) -> tuple[str, str, int]:
    return str(channel.get("column", channel.get("field"))), channel["unit"], channel.get("sign", 1)


def plain(motion: Motion) -> dict[str, Array]:
    (q1, q2), (u1, u2) = motion.position.T, motion.torque.T
    return {"time": motion.time, "shoulder_pos": q1, "elbow_pos": q2, "shoulder_torque": u1, "elbow_torque": u2}


def permuted(motion: Motion) -> dict[str, Array]:
    (q1, q2), (u1, u2) = motion.position.T, motion.torque.T
    return {
        "t_ms": 1e3 * motion.time,
        "elbow_angle": DEGREES * q2,
        "shoulder_angle": DEGREES * q1,
        "elbow_torque": -1e3 * u2,
        "shoulder_torque": 1e3 * u1,
    }


def nameless(motion: Motion) -> dict[str, Array]:
    """No column says what it is; b turns the other way."""
    (q1, q2), (v1, v2), (u1, u2) = motion.position.T, motion.velocity.T, motion.torque.T
    return {"t": motion.time, "a": u2, "b": q2, "c": v1, "d": q1, "e": v2, "f": -u1}


Rows = list[tuple[object, ...]]
READINGS: dict[str, tuple[Columns, Rows, Rows]] = {
    "plain": (
        plain,
        [("shoulder_pos", "rad", 1), ("elbow_pos", "rad", 1)],
        [("shoulder_torque", "N·m", 1), ("elbow_torque", "N·m", 1)],
    ),
    "permuted, degrees, milli, a turned command": (
        permuted,
        [("shoulder_angle", "deg", 1), ("elbow_angle", "deg", 1)],
        [("shoulder_torque", "mN·m", 1), ("elbow_torque", "mN·m", -1)],
    ),
    "nameless, a turned command": (
        nameless,
        [("d", "rad", 1), ("b", "rad", 1)],
        [("f", "N·m", -1), ("a", "N·m", 1)],
    ),
}


def robots_and_readings() -> Iterator[object]:
    """Tables with names beside one robot each; what remains is left to the slow tests."""
    for (name, reading), fast in zip(READINGS.items(), ("two.xml", "two.urdf", "none"), strict=True):
        for robot in ("two.urdf", "two.xml"):
            marks = [] if robot == fast else [pytest.mark.slow]
            yield pytest.param(robot, *reading, id=f"{name}-{robot}", marks=marks)


@pytest.mark.parametrize(("robot", "columns", "outputs", "commands"), list(robots_and_readings()))
def test_columns_units_and_signs_are_those_of_the_machine(
    robot: str, columns: Columns, outputs: Rows, commands: Rows, capsys: pytest.CaptureFixture[str]
) -> None:
    found = proposed(robot, write_logs(columns))
    told = capsys.readouterr().out
    assert ("Not read:\n  - c, e\n" in told) == (columns is nameless)  # velocities
    assert [abs(float(gain)) for gain in re.findall(r"; gain (\S+)", told)] == pytest.approx([1.0, 1.0], abs=0.15)
    assert [read_as(found["outputs"][f"{joint}.position"]) for joint in JOINTS] == outputs
    assert [read_as(found["commands"][joint]) for joint in JOINTS] == commands
    assert found["held_out"] == ["log_1"]  # the last reaches farther than the others


@pytest.mark.parametrize("turned", list(itertools.product((1, -1), repeat=2)))
def test_a_joint_is_turned_against_the_other_as_in_the_log(
    turned: tuple[int, int], capsys: pytest.CaptureFixture[str]
) -> None:
    """Both joints turned, with their commands, are the same machine in a mirror, which is said."""
    found = proposed("two.xml", write_logs(lambda m: plain(m) | turn(m, turned)))
    signs = [read_as(found["outputs"][f"{joint}.position"])[2] for joint in JOINTS]
    drives = [read_as(found["commands"][joint])[2] for joint in JOINTS]
    assert signs[0] * signs[1] == turned[0] * turned[1]
    assert [a * b for a, b in zip(signs, drives, strict=True)] == list(turned)
    told = capsys.readouterr().out
    assert ("As good with the signs of shoulder and elbow turned" in told) == (turned != (1, 1))


def turn(motion: Motion, signs: tuple[int, int]) -> dict[str, Array]:
    """Positions turned, commands left as they are."""
    return {
        f"{joint}_pos": sign * motion.position[:, j] for j, (joint, sign) in enumerate(zip(JOINTS, signs, strict=True))
    }


@pytest.mark.slow
def test_an_angle_that_counts_from_upright_gets_an_offset() -> None:
    found = proposed("two.xml", write_logs(lambda m: plain(m) | {"shoulder_pos": m.position[:, 0] + np.pi}))
    assert abs(found["outputs"]["shoulder.position"]["offset"]) == pytest.approx(np.pi)
    assert "offset" not in found["outputs"]["elbow.position"]


def test_a_bag_folder_gives_topics_and_fields() -> None:
    logs = [
        str(write_bag(Path(f"run_{k}"), JOINTS, m.time, m.position, command=m.torque)) for k, m in enumerate(motions())
    ]
    found = proposed("two.urdf", logs)
    assert found["outputs"]["elbow.position"] == {
        "topic": "/joint_states",
        "field": "position[elbow]",
        "unit": "rad",
    }
    assert found["commands"]["elbow"]["field"] == "data[1]"
    assert (found["clock"], found["commands"]["elbow"]["clock"]) == ("header", "log")


def test_a_urdf_gets_motors_and_the_model_is_that_of_the_mjcf() -> None:
    proposed("two.urdf", write_logs(plain))
    made, given = mujoco.MjModel.from_xml_path("mine/model/two.xml"), mujoco.MjModel.from_xml_string(MJCF)
    assert made.nu == given.nu == 2
    for field in ("body_mass", "body_inertia", "dof_damping", "actuator_gainprm", "actuator_trnid"):
        np.testing.assert_allclose(getattr(made, field), getattr(given, field), rtol=1e-5, atol=1e-12)
    model = yaml.safe_load(Path("mine/model/two.yaml").read_text(encoding="utf-8"))
    assert list(model["parameters"]) == ["upper.mass", "lower.mass", "shoulder.damping", "elbow.damping"]
    for entry in model["parameters"].values():
        assert entry["low"] < entry["high"]
    page = Path("mine/model/two.yaml").read_text(encoding="utf-8")
    assert ".mass scales the body's inertia with it" in page
    assert ".inertia_scale is a factor on the inertia alone." in page


def test_an_unchanged_mjcf_is_copied_to_the_letter() -> None:
    proposed("two.xml", write_logs(plain))
    assert Path("mine/model/two.xml").read_text() == MJCF


def test_a_servo_is_added_where_commands_are_positions(capsys: pytest.CaptureFixture[str]) -> None:
    """The machine: a torque kp (r − q) − kv q' at each joint."""
    rows = [write_csv(Path(f"logs/log_{k}.csv"), servo_log(k)) for k in range(2)]
    found = proposed("two.urdf", list(map(str, rows)))
    made = mujoco.MjModel.from_xml_path("mine/model/two.xml")
    np.testing.assert_allclose(made.actuator_gainprm[:, 0], [40.0, 15.0], rtol=0.1)
    np.testing.assert_allclose(-made.actuator_biasprm[:, 2], [2.0, 0.6], rtol=0.3)
    assert [read_as(found["commands"][joint]) for joint in JOINTS] == [
        ("shoulder_target", "rad", 1),
        ("elbow_target", "rad", 1),
    ]
    assert "a servo towards the command" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere.xml", "logs/*.csv"], r"There is no file 'nowhere.xml'; . holds broken.urdf, .*two.xml"),
        (["two.xml", "nowhere/*.mcap"], r"No file matches 'nowhere/\*.mcap'"),
        (["broken.urdf", "logs/*.csv"], r"broken.urdf is no valid XML"),
        (["massless.urdf", "logs/*.csv"], r"link 'lower' moves but has no inertia.*Give it an <inertial>"),
        (["other.xml", "logs/*.csv"], r"No series of the logs fits a joint of the robot. Joints: a, b, c"),
        (["unknown_robot", "logs/*.csv"], r"There is no file or folder 'unknown_robot'.*robot_descriptions"),
        (["two.xml", "other/log.csv"], r"log.csv has no clock: .*Add a column time"),
        pytest.param(
            ["two.xml", "still/log.csv"],
            r"No series of the logs fits a joint|moves as shoulder, elbow do",
            marks=pytest.mark.slow,
        ),
        (["two.xml"], r"No value for logs"),
    ],
)
def test_wrong_input_is_named_and_nothing_is_written(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    write_logs(plain)
    motion = motions()[0]
    Path("broken.urdf").write_text("<robot><link name='a'>")
    Path("massless.urdf").write_text(
        URDF.replace(URDF[URDF.index('<link name="lower">') :].split("</link>")[0], '<link name="lower">')
    )
    joints = "".join(f'<body><joint name="{n}" axis="0 1 0"/><geom size="0.1"/></body>' for n in ("a", "b", "c"))
    Path("other.xml").write_text(f"<mujoco><worldbody>{joints}</worldbody></mujoco>")
    write_csv(Path("other/log.csv"), {"q": motion.position[:, 0]})
    noise = np.random.default_rng(0).normal(size=(2, len(motion.time))).cumsum(1)
    write_csv(Path("still/log.csv"), {"time": motion.time, "q1": noise[0], "q2": noise[1]})
    assert main(["init", *arguments]) == 2
    told = capsys.readouterr().err
    assert "Traceback" not in told
    assert re.search(message, told), told
    assert not Path("mine").exists()


def test_what_is_there_is_not_written_over(capsys: pytest.CaptureFixture[str]) -> None:
    logs = write_logs(plain)
    proposed("two.xml", logs)
    Path("mine/model/two.yaml").write_text("my own work")
    assert main(["init", "two.xml", *logs]) == 2
    assert "There is already mine/model/two.xml" in capsys.readouterr().err
    assert Path("mine/model/two.yaml").read_text() == "my own work"
    assert main(["init", "two.xml", *logs, "overwrite=true"]) == 0
    assert "parameters:" in Path("mine/model/two.yaml").read_text()


@pytest.mark.slow
def test_folder_and_name_are_those_asked_for() -> None:
    assert main(["init", "two.xml", *write_logs(plain), "output=other", "name=arm"]) == 0
    assert Path("other/measurements/arm.yaml").is_file()


def test_shapes_that_overlap_all_the_time_are_told_and_excluded(capsys: pytest.CaptureFixture[str]) -> None:
    ball = '<geom name="{0}" type="sphere" size="0.05" pos="0 0 {1}"/>'
    xml = MJCF.replace('<body name="upper">', ball.format("post", 0) + '<body name="upper">' + ball.format("hub", 0))
    Path("two.xml").write_text(xml)
    proposed("two.xml", write_logs(plain))
    assert "world and upper overlap in the whole motion" in capsys.readouterr().out
    assert mujoco.MjModel.from_xml_path("mine/model/two.xml").nexclude == 1


@pytest.mark.slow
def test_a_coarse_time_step_is_told_and_a_urdf_gets_a_fine_one(capsys: pytest.CaptureFixture[str]) -> None:
    Path("two.xml").write_text(MJCF.replace('timestep="0.002" integrator="RK4"', 'timestep="0.01"'))
    proposed("two.xml", write_logs(plain))
    assert "The time step of 0.01 s alone moves" in capsys.readouterr().out
    proposed("two.urdf", write_logs(plain), "overwrite=true", "proposal.timestep=0.03")
    assert mujoco.MjModel.from_xml_path("mine/model/two.xml").opt.timestep < 0.03


def test_the_peak_of_the_commands_is_as_planned() -> None:
    """Else gains say nothing."""
    assert np.abs(motions()[0].torque).max(0) == pytest.approx(PEAK, rel=0.1)


@pytest.mark.slow
def test_logs_that_the_robot_does_not_explain_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    """Another arm whose joints are called the same."""
    Path("two.xml").write_text(MJCF.replace('pos="0 0 -0.15"', 'pos="0.3 0 0.1"').replace('mass="0.8"', 'mass="3"'))
    found = proposed("two.xml", write_logs(plain))
    assert "the logs may be of another robot" in capsys.readouterr().out
    assert "offset" not in found["outputs"]["shoulder.position"]
    page = " ".join(line.lstrip("# ") for line in Path("mine/measurements/two.yaml").read_text().splitlines())
    assert "the logs may be of another robot" in page


def test_what_inverse_dynamics_cannot_test_is_by_name(capsys: pytest.CaptureFixture[str]) -> None:
    inertial = '<inertial mass="0.01" pos="0 0 0" diaginertia="1e-5 1e-5 1e-5"/>'
    finger = f'<body>{inertial}<joint name="finger" type="slide"/></body>'
    elbow = '<joint name="elbow" axis="0 1 0" damping="0.03"/>'
    Path("two.xml").write_text(MJCF.replace(elbow, elbow + finger))
    found = proposed("two.xml", write_logs(plain))
    assert list(found["outputs"]) == ["shoulder.position", "elbow.position"]
    told = capsys.readouterr().out
    assert "Signs and units are by name alone" in told
    assert "No series is said to be finger" in told


def test_of_two_mirrored_readings_that_within_the_joints_ranges_is_taken() -> None:
    """Both directions of the elbow are turned with its command; its range in the model is on one side of zero."""
    every = [m.position[:, 1] for m in motions()]
    low, high = min(map(np.min, every)) - 0.1, max(map(np.max, every)) + 0.1
    ranged = f'<joint name="elbow" range="{low} {high}"'
    Path("two.xml").write_text(MJCF.replace('<joint name="elbow"', ranged))
    assert abs(low + high) > 0.2, "else both directions are within"
    found = proposed("two.xml", write_logs(lambda m: plain(m) | turn(m, (-1, -1))))
    assert [read_as(found["outputs"][f"{joint}.position"])[2] for joint in JOINTS] == [-1, -1]
