"""Descriptions and logs in all the forms in which `dr-lab init` takes them."""

import gzip
import json
import shlex
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import mujoco
import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
import yaml
from own_robot import JOINTS, MJCF, URDF, Motion, plain_logs

from dr_lab.__main__ import main
from dr_lab.errors import DataError, ModelError
from dr_lab.measurements.inventory import columns_of
from dr_lab.proposal.robot import read_robot
from dr_lab.proposal.split import Split
from dr_lab.proposal.time_column import find_clock
from dr_lab.proposal.words import read_name


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("two.urdf").write_text(URDF)
    Path("two.xml").write_text(MJCF)
    return tmp_path


def measurements() -> dict[str, Any]:
    return yaml.safe_load(Path("mine/measurements/two.yaml").read_text(encoding="utf-8"))


def test_a_lerobot_data_set(here: Path) -> None:
    """Lists as columns, episodes in one file, joints named in meta/info.json in another order than the robot's."""
    rows: dict[str, list[object]] = {key: [] for key in ("observation.state", "action", "timestamp", "episode_index")}
    for episode in range(3):
        motion = Motion(episode)
        rows["observation.state"] += motion.position[:, ::-1].tolist()
        rows["action"] += motion.torque[:, ::-1].tolist()
        rows["timestamp"] += motion.time.tolist()
        rows["episode_index"] += [episode] * len(motion.time)
    path = here / "set" / "data" / "chunk-000" / "file-000.parquet"
    path.parent.mkdir(parents=True)
    pyarrow.parquet.write_table(pa.table(rows), path)
    names = {"names": ["elbow.pos", "shoulder.pos"]}
    (here / "set" / "meta").mkdir()
    info = {"features": {"observation.state": names, "action": {"names": ["elbow.effort", "shoulder.effort"]}}}
    (here / "set" / "meta" / "info.json").write_text(json.dumps(info))
    assert main(["init", "two.urdf", str(path)]) == 0
    found = measurements()
    assert found["group"] == "episode_index"
    assert found["held_out"] == ["file-000/1"]  # the last reaches farther than the others
    assert found["outputs"]["shoulder.position"] == {"column": "observation.state[1]", "unit": "rad"}
    assert found["commands"]["elbow"] == {"column": "action[0]", "unit": "N·m"}


def test_compressed_tables_and_a_single_log(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (path,) = plain_logs(here / "logs", 1)
    packed = path.with_suffix(".csv.gz")
    packed.write_bytes(gzip.compress(path.read_bytes()))
    assert main(["init", "two.xml", str(packed)]) == 0
    found = measurements()
    assert (found["fit"], found["held_out"]) == (["log_0[:3.96]"], ["log_0[3.96:]"])
    assert "two: 1 log, its first 3.96 s fitted and the rest held out, " in capsys.readouterr().out


@pytest.mark.parametrize(
    ("logs", "split", "said"),
    [
        (3, Split((), None, ("c",), {}), "3 logs, 1 held out"),
        (3, Split((), ("a",), ("b",), {"c": "short"}), "3 logs, 1 left out, 1 held out"),
        (1, Split((), ("a[:4]",), ("a[4:]",), {}, 4.0), "1 log, its first 4 s fitted and the rest held out"),
        (
            2,
            Split((), ("a[:4]",), ("a[4:]",), {"b": "short"}, 4.0),
            "2 logs, 1 left out, of the other the first 4 s fitted and the rest held out",
        ),
    ],
)
def test_how_logs_are_used_in_a_few_words(logs: int, split: Split, said: str) -> None:
    assert split.said(logs) == said


@pytest.mark.slow
def test_a_log_that_cannot_be_used_is_left_out_with_the_reason(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    logs = plain_logs(here / "logs", 4)
    text = logs[1].read_text().splitlines()
    logs[1].write_text("\n".join([text[0], *text[1:12]]) + "\n")
    assert main(["init", "two.xml", *map(str, logs), "proposal.logs=1"]) == 0
    found = measurements()
    assert not {"log_1"} & {*found["fit"], *found["held_out"]}
    assert "log_1: Log 'log_1': channel 'shoulder.position'" in capsys.readouterr().out


@pytest.mark.slow
def test_a_folder_with_a_scene_beside_the_robot_and_its_meshes(here: Path) -> None:
    folder = here / "menagerie" / "acme_two"
    (folder / "assets").mkdir(parents=True)
    (folder / "assets" / "box.obj").write_text(
        "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
    mesh = '<asset><mesh name="box" file="box.obj"/></asset><worldbody>'
    text = MJCF.replace('<compiler angle="radian"/>', '<compiler angle="radian" meshdir="assets"/>')
    text = text.replace("<worldbody>", mesh).replace(
        '<body name="upper">', '<body name="upper"><geom type="mesh" mesh="box" contype="0" conaffinity="0" mass="0"/>'
    )
    (folder / "two.xml").write_text(text)
    (folder / "scene.xml").write_text('<mujoco><include file="two.xml"/></mujoco>')
    logs = plain_logs(here / "logs")
    assert main(["init", str(folder), *map(str, logs)]) == 0
    assert mujoco.MjModel.from_xml_path("mine/model/two.xml").nmesh == 1
    (folder / "other.xml").write_text(MJCF)
    assert read_robot(str(folder), None).path.name == "two.xml"  # acme_two
    unlike = folder.rename(folder.with_name("unlike"))
    with pytest.raises(ModelError, match=r"holds other\.xml, two\.xml\. Name one file"):
        read_robot(str(unlike), None)


def test_meshes_of_a_package_are_found_and_others_left_out(here: Path) -> None:
    package = here / "acme_description"
    (package / "meshes").mkdir(parents=True)
    (package / "urdf").mkdir()
    (package / "meshes" / "a.obj").write_text(
        "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
    shape = '<{0}><geometry><mesh filename="package://acme_description/meshes/{1}"/></geometry></{0}>'
    text = URDF.replace('<link name="upper">', '<link name="upper">' + shape.format("collision", "a.obj"))
    text = text.replace('<link name="lower">', '<link name="lower">' + shape.format("collision", "b.stl"))
    text = text.replace("</link>", shape.format("visual", "c.dae") + "</link>", 1)
    (package / "urdf" / "two.urdf").write_text(text)
    robot = read_robot(str(package / "urdf" / "two.urdf"), None)
    assert robot.spec.copy().compile().nmesh == 1
    assert robot.notes == (
        "Link 'lower' makes no contact: its mesh package://acme_description/meshes/b.stl is not there.",
    )


def test_links_that_are_welded_together_are_one(here: Path) -> None:
    """A heavy tool on a light link."""
    tool = """<link name="tool"><inertial><origin xyz="0 0 0"/><mass value="3"/>
      <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="mount" type="fixed"><parent link="lower"/><child link="tool"/><origin xyz="0 0 -0.1"/></joint>"""
    Path("two.urdf").write_text(URDF.replace("</robot>", f"{tool}</robot>"))
    assert main(["init", "two.urdf", *map(str, plain_logs(here / "logs"))]) == 0
    np.testing.assert_allclose(mujoco.MjModel.from_xml_path("mine/model/two.xml").body_mass, [0.0, 0.8, 3.4])
    mass = yaml.safe_load(Path("mine/model/two.yaml").read_text(encoding="utf-8"))["parameters"]["lower.mass"]
    assert mass["low"] < 3.4 < mass["high"]


def test_links_that_are_welded_in_a_ring_are_told() -> None:
    ring = "".join(
        f'<joint name="{a}{b}" type="fixed"><parent link="{a}"/><child link="{b}"/></joint>'
        for a, b in (("upper", "hand"), ("hand", "upper"))
    )
    Path("two.urdf").write_text(URDF.replace("</robot>", f'<link name="hand"/>{ring}</robot>'))
    with pytest.raises(ModelError, match=r"two.urdf does not compile: .*Correct it in the URDF"):
        read_robot("two.urdf", None)


def test_a_name_of_robot_descriptions(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The package is stood for by modules of the same names."""
    package, listed, robot = (
        ModuleType(f"robot_descriptions{name}") for name in ("", "._descriptions", ".two_description")
    )
    package.__path__, package.__spec__ = [], None
    listed.__dict__["DESCRIPTIONS"] = {"two_description": None}
    robot.__dict__["URDF_PATH"] = str(here / "two.urdf")
    for module in (package, listed, robot):
        monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: object())
    assert read_robot("two", None).joints == JOINTS
    with pytest.raises(Exception, match="There is no robot 'three' in robot_descriptions"):
        read_robot("three", None)


def test_inertias_that_are_guessed_are_told(here: Path) -> None:
    ball = '<inertial mass="0.4" pos="0 0 -0.1" diaginertia="0.002 0.002 0.0005"/>'
    Path("light.xml").write_text(MJCF.replace(ball, '<geom size="0.05"/>'))
    assert (
        read_robot("light.xml", None).notes[0].startswith("Body lower has no <inertial>: masses follow from the shapes")
    )
    inertial = URDF[URDF.index('<link name="lower">') :].split("</link>")[0]
    Path("light.urdf").write_text(
        URDF.replace(inertial, '<link name="lower"><collision><geometry><sphere radius="0.05"/></geometry></collision>')
    )
    assert read_robot("light.urdf", None).notes[0].startswith("Link 'lower' has no <inertial>: its mass follows from")


@pytest.mark.parametrize(
    ("header", "step", "column", "unit"),
    [
        ("time", 0.002, "time", "s"),
        ("t_ms", 2.0, "t_ms", "ms"),
        ("timestamp", 2000000, "timestamp", "ns"),
        ("time_us", 2000.0, "time_us", "us"),
        ("stamp", 2000.0, "stamp", "us"),
        ("time_s", 2.0, "time_s", "ms"),
        ("Zeit [s]", 0.002, "Zeit [s]", "s"),
    ],
)
def test_the_unit_of_a_clock(here: Path, header: str, step: float, column: str, unit: str) -> None:
    """By name, by the period, and by the period where the name cannot be right."""
    lines = [f"index,{header},q", *(f"{k},{k * step},{k % 7}" for k in range(100))]
    (here / "a.csv").write_text("\n".join(lines))
    clock = find_clock(here / "a.csv")
    assert (clock.axis.column, clock.axis.unit) == (column, unit)
    assert ("its name says s" in clock.doubt) == (header == "time_s")


def test_a_table_without_a_clock(here: Path) -> None:
    (here / "a.csv").write_text("step,q\n" + "\n".join(f"{k},{k % 7}" for k in range(100)))
    with pytest.raises(DataError, match="Columns that rise, but are not called time: step"):
        find_clock(here / "a.csv")


def test_a_clock_of_whole_seconds(here: Path) -> None:
    rows = "\n".join(f"{1764249896 + k // 3},{0.1 * k:.1f}" for k in range(60))
    (here / "a.csv").write_text(f"Time (s),RPM\n{rows}\n")
    with pytest.raises(
        DataError, match=r"a.csv has no clock: Time \(s\) rises, but keeps its value over 3 rows\. Write"
    ):
        find_clock(here / "a.csv")


def test_a_table_without_a_header(here: Path) -> None:
    """The first row begins with two equal numbers, which no two columns are called."""
    (here / "a.csv").write_text("\n".join(f"{0.01 * k:.2f},{0.01 * (k % 7):.2f}" for k in range(100)))
    with pytest.raises(DataError, match=r"a.csv: the first line, .*seems to be missing.*The line is 0\.00, 0\.00\."):
        find_clock(here / "a.csv")


@pytest.mark.parametrize(
    ("topic", "path", "label", "kind", "unit"),
    [
        ("", "pos_meas1", "", "position", ""),
        ("", "theta_dot_rad_s", "", "velocity", "rad/s"),
        ("", "elbowTorque_mNm", "", "drive", "mN·m"),
        ("", "q_ref_m", "", "reference", "m"),
        ("", "u_cmd_V", "", "drive", "V"),
        ("", "u_mV", "", "drive", "mV"),
        ("", "i_cmd_mA", "", "drive", "mA"),
        ("", "joint_3_deg", "", "position", "deg"),
        ("", "c3", "", "", ""),
        ("", "rpm", "", "velocity", "rpm"),
        ("", "deg", "", "position", "deg"),
        ("", "turn", "", "", ""),
        ("", "frame_index", "", "other", ""),
        ("/joint_states", "position[elbow]", "elbow", "position", ""),
        ("/joint_states", "effort[elbow]", "elbow", "drive", ""),
        ("/arm_controller/state", "actual.positions[0]", "elbow", "position", ""),
        ("/arm_controller/state", "desired.positions[0]", "elbow", "reference", ""),
        ("/effort_controller/commands", "data[0]", "", "drive", ""),
        ("/position_controllers/commands", "data[0]", "", "reference", ""),
        ("", "observation.state[2]", "elbow_flex.pos", "position", ""),
        ("", "action[2]", "elbow_flex.pos", "reference", ""),
    ],
)
def test_what_a_name_says(topic: str, path: str, label: str, kind: str, unit: str) -> None:
    words = read_name(topic, path, label)
    assert (words.kind, words.unit) == (kind, unit)


def test_entries_of_lists_are_places(here: Path) -> None:
    table = pa.table({"timestamp": [0.0, 0.1], "state": [[1.0, 2.0], [3.0, 4.0]], "name": ["a", "b"], "n": [1, 2]})
    pyarrow.parquet.write_table(table, here / "a.parquet")
    assert [place.path for place in columns_of(here / "a.parquet")] == ["timestamp", "state[0]", "state[1]", "n"]
    assert np.all([place.clock == "column" for place in columns_of(here / "a.parquet")])


def test_the_next_command_can_be_typed(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (path,) = plain_logs(here / "logs", 1)
    assert main(["init", "two.xml", str(path), "output='my robot'", "name='17'"]) == 0
    told = capsys.readouterr().out.split("Next: ")[1]
    words = ["dr-lab", "close", "--config-dir", "my robot", "model='17'", "measurements='17'"]
    assert shlex.split(told) == words


def test_where_a_wrong_guess_is_corrected(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (path,) = plain_logs(here / "logs", 1)
    assert main(["init", "two.xml", str(path)]) == 0
    written = "mine/measurements/two.yaml"
    told = f"Where a guess is wrong, correct it under outputs, commands or contract of {written},"
    assert told in capsys.readouterr().out
    page = Path(written)
    text = page.read_text(encoding="utf-8")
    line = "contract: {speed_limit: 400}"
    assert f"# {line}, in rad/s" in text
    page.write_text(f"{text}{line}\n", encoding="utf-8")
    compare = ["compare", "--config-dir", "mine", "model=two", "measurements=two"]
    assert main([*compare, "--cfg", "job", "-p", "measurements.contract"]) == 0
    shown = yaml.safe_load(capsys.readouterr().out)
    assert (shown["speed_limit"], shown["gap"]) == (400, 5.0)
