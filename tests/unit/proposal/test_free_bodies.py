"""`dr-lab init` on bodies that fly: positions, orientations and rates of logs become sensors of the model."""

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml
from own_robot import write_csv
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_typestore

from dr_lab.__main__ import main
from dr_lab.trajectory import Array

DEGREES = 180 / np.pi
STEP = 0.004  # s
DRONE = """<mujoco model="drone">
  <compiler angle="radian"/>
  <option timestep="0.002" integrator="RK4"/>
  <worldbody><body name="frame" pos="0 0 1">
    <freejoint name="root"/>
    <inertial mass="0.8" pos="0 0 0" diaginertia="0.005 0.004 0.009"/>
    <site name="left" pos="0 0.1 0"/>
    <site name="right" pos="0 -0.1 0"/>
    %s
  </body></worldbody>
  <actuator>
    <motor name="left" site="left" gear="0 0 1 0 0 0.02"/>
    <motor name="right" site="right" gear="0 0 1 0 0 -0.02"/>
  </actuator>
  <sensor>%s</sensor>
</mujoco>"""
BARE = DRONE % ("", "")
WITH_SENSORS = DRONE % (
    '<site name="chip" pos="0.01 0 0"/>',
    '<framepos name="mocap" objtype="xbody" objname="frame"/><gyro name="chip_rate" site="chip"/>',
)
FRAMES = ("framepos", "framequat")
WITH_ARM = BARE.replace(
    "</body></worldbody>",
    '<body name="arm"><joint name="hinge" axis="0 1 0"/>'
    '<inertial mass="0.1" pos="0 0 -0.1" diaginertia="1e-3 1e-3 1e-4"/></body></body></worldbody>',
)


@cache
def flight(seed: int, xml: str = BARE) -> dict[str, Array]:
    """2 s of tumbling: what is measured, with the noise of good instruments, and the two commands."""
    model = mujoco.MjModel.from_xml_string(xml)
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    data.qvel[:6] = rng.normal(scale=[0.5, 0.5, 0.5, 1.0, 1.0, 1.0])
    rows = []
    for k in range(500):
        if k % 25 == 0:
            data.ctrl[:] = rng.uniform(3.0, 5.0, 2)
        rows.append(np.concatenate([[data.time], data.qpos, data.qvel[3:6], data.ctrl]))
        for _ in range(round(STEP / model.opt.timestep)):
            mujoco.mj_step(model, data)
    table, joints = np.array(rows), model.nq - 7
    table[:, 1:4] += 1e-3 * rng.normal(size=(500, 3))
    table[:, 4:8] += 1e-3 * rng.normal(size=(500, 4))
    table[:, 8 + joints : 11 + joints] += 5e-3 * rng.normal(size=(500, 3))
    names = ["time", "x", "y", "z", "qw", "qx", "qy", "qz", *["hinge_pos"][:joints], "gx", "gy", "gz", "u1", "u2"]
    return dict(zip(names, table.T, strict=True))


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def proposed(xml: str, *tables: Mapping[str, Array]) -> dict[str, Any]:
    """The written measurements of a robot with these logs."""
    Path("drone.xml").write_text(xml)
    logs = [str(write_csv(Path(f"logs/flight_{k}.csv"), table)) for k, table in enumerate(tables)]
    assert main(["init", "drone.xml", *logs]) == 0
    return yaml.safe_load(Path("mine/measurements/drone.yaml").read_text(encoding="utf-8"))


def parameters() -> dict[str, Any]:
    return yaml.safe_load(Path("mine/model/drone.yaml").read_text(encoding="utf-8"))["parameters"]


def test_a_free_body_gets_the_sensors_that_the_logs_ask_for() -> None:
    found = proposed(BARE, *(flight(seed) for seed in range(3)))
    assert found["outputs"] == {
        "sensor.frame_position": {"column": ["x", "y", "z"], "unit": "m"},
        "sensor.frame_orientation": {"column": ["qw", "qx", "qy", "qz"], "unit": "1"},
        "sensor.frame_rate": {"column": ["gx", "gy", "gz"], "unit": "rad/s"},
    }
    commands = {name: (each["column"], each["unit"]) for name, each in found["commands"].items()}
    assert commands == {"left": ("u1", "N"), "right": ("u2", "N")}
    assert parameters() == {"inertial": ["frame"]}
    model = mujoco.MjModel.from_xml_path("mine/model/drone.xml")
    assert [model.sensor(i).name for i in range(3)] == ["frame_position", "frame_orientation", "frame_rate"]


@pytest.mark.slow
def test_what_was_written_compares(capsys: pytest.CaptureFixture[str]) -> None:
    proposed(BARE, *(flight(seed) for seed in range(3)))
    run = ["--config-dir", "mine", "model=drone", "measurements=drone", "hydra.run.dir=run"]
    assert main(["compare", *run]) == 0
    assert "sensor.frame_orientation" in capsys.readouterr().out


@pytest.mark.slow
def test_what_an_accelerometer_reads_is_compared_in_its_unit() -> None:
    """Of a body that nothing holds: what the motors pull, over the mass."""

    def felt(table: Mapping[str, Array], seed: int) -> dict[str, Array]:
        noise = 0.05 * np.random.default_rng(seed).normal(size=(3, len(table["time"])))
        pull = np.stack([0 * table["u1"], 0 * table["u1"], (table["u1"] + table["u2"]) / 0.8]) + noise
        return {**table, **{f"accel_{axis}_m_s2": row for axis, row in zip("xyz", pull, strict=True)}}

    found = proposed(BARE, *(felt(flight(seed), seed) for seed in range(3)))
    columns = [f"accel_{axis}_m_s2" for axis in "xyz"]
    assert found["outputs"]["sensor.frame_acceleration"] == {"column": columns, "unit": "m/s^2"}
    run = ["--config-dir", "mine", "model=drone", "measurements=drone", "hydra.run.dir=run"]
    assert main(["compare", *run]) == 0
    report = json.loads(Path("run/report.json").read_text(encoding="utf-8"))
    left = report["ladder"][0]["held_out"]
    assert left["rmse"]["sensor.frame_acceleration"] == pytest.approx(0.05, rel=0.1)  # m/s², the noise
    assert left["chi2"] == pytest.approx(1.0, abs=0.1)


def test_degrees_and_another_order_are_seen(capsys: pytest.CaptureFixture[str]) -> None:
    def other(table: Mapping[str, Array]) -> dict[str, Array]:
        names = {"orientation.x": "qx", "orientation.y": "qy", "orientation.z": "qz", "orientation.w": "qw"}
        turned = {f"imu.{axis}_rad_s": DEGREES * table[f"g{axis}"] for axis in "xyz"}
        return {"time": table["time"], **{new: table[old] for new, old in names.items()}, **turned}

    found = proposed(WITH_SENSORS, *(other(flight(seed)) for seed in range(3)))
    orientation = found["outputs"]["sensor.frame_orientation"]
    assert orientation["column"] == [f"orientation.{axis}" for axis in "wxyz"]
    assert found["outputs"]["sensor.chip_rate"]["unit"] == "deg/s"
    assert "turns as deg/s would, not as rad/s" in capsys.readouterr().out


def test_rates_of_another_frame_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    logs = [flight(seed) for seed in range(3)]
    proposed(BARE, *({**log, "gx": log["gy"], "gy": -log["gz"], "gz": log["gx"]} for log in logs))
    assert "turns another way than the orientation" in capsys.readouterr().out


def test_rates_that_are_differences_of_the_orientation_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    def made(log: Mapping[str, Array]) -> dict[str, Array]:
        quaternion = np.stack([log[name] for name in ("qw", "qx", "qy", "qz")], axis=-1)
        rate, turn = np.zeros((len(quaternion), 3)), np.empty(4)
        for k in range(len(quaternion) - 1):
            mujoco.mju_negQuat(turn, quaternion[k])
            mujoco.mju_mulQuat(turn, turn, quaternion[k + 1])
            mujoco.mju_quat2Vel(rate[k], turn, STEP)
        return {**log, **dict(zip(("gx", "gy", "gz"), rate.T, strict=True))}

    proposed(BARE, *(made(flight(seed)) for seed in range(3)))
    assert "if it was computed from that, delete it" in capsys.readouterr().out


def test_a_sensor_may_be_called_position(capsys: pytest.CaptureFixture[str]) -> None:
    sensor = '<framepos name="position" objtype="xbody" objname="frame"/>'
    found = proposed(DRONE % ("", sensor), flight(0), flight(1))
    assert found["outputs"]["sensor.position"] == {"column": ["x", "y", "z"], "unit": "m"}
    assert "refuse" not in capsys.readouterr().out


@pytest.mark.parametrize(("kind", "shifted", "told"), [("body", 1, True), ("body", 0, False), ("xbody", 1, False)])
def test_sensors_of_the_inertia_are_told_where_its_frame_is_another(
    kind: str, shifted: int, told: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    xml = DRONE % ("", "".join(f'<{sort} name="{sort}" objtype="{kind}" objname="frame"/>' for sort in FRAMES))
    frame = f'pos="0 0 {0.02 * shifted}" euler="0 0 {0.5 * shifted}" diaginertia'
    proposed(xml.replace('pos="0 0 0" diaginertia', frame), flight(0), flight(1))
    out = " ".join(capsys.readouterr().out.split())
    assert ("reads the centre of mass, 0.02 m away from the frame of body frame" in out) == told
    assert ("reads the axes of inertia, turned by 28.6° from the frame of body frame" in out) == told
    assert ('write objtype="xbody"' in out) == told


def test_a_joint_of_a_body_that_flies_is_an_output_beside_it() -> None:
    found = proposed(WITH_ARM, *(flight(seed, WITH_ARM) for seed in range(3)))
    assert found["outputs"]["hinge.position"]["column"] == "hinge_pos"
    assert len(found["outputs"]) == 4
    assert "hinge.damping" in parameters()


def test_what_nothing_drives_keeps_its_mass() -> None:
    ball = BARE[: BARE.index("<actuator>")] + "</mujoco>"
    proposed(ball, *({k: v for k, v in flight(seed).items() if k not in ("u1", "u2")} for seed in range(3)))
    assert list(parameters()) == ["frame.inertia_scale"]


def test_logs_of_something_else_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    Path("drone.xml").write_text(BARE)
    time = np.arange(0.0, 2.0, STEP)
    log = str(write_csv(Path("logs/heat.csv"), {"time": time, "oven_temperature": 20.0 + time}))
    assert main(["init", "drone.xml", log]) == 2
    assert "No series of the logs is a position (x, y, z)" in capsys.readouterr().err


def test_a_pose_and_an_imu_of_a_bag() -> None:
    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds = {name.split("/")[-1]: kind for name, kind in store.types.items()}
    log, logs = flight(0), []
    for k in range(2):
        with Writer(Path(f"run_{k}"), version=8) as writer:
            pose = writer.add_connection("/vrpn/pose", "geometry_msgs/msg/PoseStamped", typestore=store)
            imu = writer.add_connection("/imu", "sensor_msgs/msg/Imu", typestore=store)
            still, empty = np.zeros(9), kinds["Quaternion"](x=0.0, y=0.0, z=0.0, w=0.0)
            for i, at in enumerate((1e9 * log["time"]).astype(np.int64).tolist()):
                x, y, z, qw, qx, qy, qz, gx, gy, gz = (
                    float(log[name][i]) for name in ("x", "y", "z", "qw", "qx", "qy", "qz", "gx", "gy", "gz")
                )
                stamp = kinds["Time"](sec=100 + at // 10**9, nanosec=at % 10**9)
                header = kinds["Header"](stamp=stamp, frame_id="world")
                place, turn = kinds["Point"](x=x, y=y, z=z), kinds["Quaternion"](x=qx, y=qy, z=qz, w=qw)
                message = kinds["PoseStamped"](header=header, pose=kinds["Pose"](position=place, orientation=turn))
                writer.write(pose, at, store.serialize_cdr(message, "geometry_msgs/msg/PoseStamped"))
                rate, pull = kinds["Vector3"](x=gx, y=gy, z=gz), kinds["Vector3"](x=0.0, y=0.0, z=9.81)
                sense = kinds["Imu"](header, empty, still, rate, still, pull, still)
                writer.write(imu, at, store.serialize_cdr(sense, "sensor_msgs/msg/Imu"))
        logs.append(f"run_{k}")
    Path("drone.xml").write_text(BARE)
    assert main(["init", "drone.xml", *logs]) == 0
    outputs = yaml.safe_load(Path("mine/measurements/drone.yaml").read_text(encoding="utf-8"))["outputs"]
    assert outputs["sensor.frame_rate"]["field"] == [f"angular_velocity.{axis}" for axis in "xyz"]
    assert outputs["sensor.frame_orientation"]["topic"] == "/vrpn/pose"
    assert outputs["sensor.frame_position"]["field"] == [f"pose.position.{axis}" for axis in "xyz"]
