"""A planar arm of two joints, as a user has it: URDF, MJCF and logs of a machine with dry friction in its elbow."""

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import mujoco
import numpy as np

from dr_lab.trajectory import Array

JOINTS = ("shoulder", "elbow")
DAMPING = (0.05, 0.03)  # N·m·s/rad
URDF = """<robot name="two">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 -0.15"/><mass value="0.8"/>
    <inertia ixx="0.006" iyy="0.006" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0 0 -0.1"/><mass value="0.4"/>
    <inertia ixx="0.002" iyy="0.002" izz="0.0005" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit effort="20" velocity="10"/><dynamics damping="0.05"/></joint>
  <joint name="elbow" type="continuous"><origin xyz="0 0 -0.3"/><parent link="upper"/><child link="lower"/>
    <axis xyz="0 1 0"/><limit effort="20" velocity="10"/><dynamics damping="0.03"/></joint>
</robot>"""
MJCF = """<mujoco model="two">
  <compiler angle="radian"/>
  <option timestep="0.002" integrator="RK4"/>
  <worldbody><body name="upper">
    <inertial mass="0.8" pos="0 0 -0.15" diaginertia="0.006 0.006 0.001"/>
    <joint name="shoulder" axis="0 1 0" damping="0.05"/>
    <body name="lower" pos="0 0 -0.3">
      <inertial mass="0.4" pos="0 0 -0.1" diaginertia="0.002 0.002 0.0005"/>
      <joint name="elbow" axis="0 1 0" damping="0.03"/>
    </body>
  </body></worldbody>
  <actuator><motor name="shoulder" joint="shoulder"/><motor name="elbow" joint="elbow"/></actuator>
</mujoco>"""
FRICTION = 0.12  # N·m, of the machine's elbow
PEAK = (3.0, 0.8)  # N·m
STEP, SAMPLE, HELD = 5e-4, 0.005, 0.1  # s


class Motion:
    """What the machine did, every 5 ms.

    Args:
        seed: of its commands, its start and its encoders' noise of 1 mrad.
        seconds: duration.
        friction: N·m, of the elbow.
    """

    def __init__(self, seed: int, seconds: float = 6.0, friction: float = FRICTION) -> None:
        found, noise = _moved(seed, seconds, friction)
        self.time: Array = np.asarray(SAMPLE * np.arange(len(found)), np.float64)
        self.position = found[:, :2] + noise
        self.velocity: Array = found[:, 2:4]
        self.torque: Array = found[:, 4:]


@cache
def _moved(seed: int, seconds: float, friction: float) -> tuple[Array, Array]:
    """Positions, velocities and torques every 5 ms, shape (n, 6), and the encoders' noise, shape (n, 2)."""
    rng = np.random.default_rng(seed)
    spec = mujoco.MjSpec.from_string(MJCF)
    spec.option.timestep = STEP
    spec.joint("elbow").frictionloss = friction
    spec.body("lower").mass *= 1.1
    spec.body("lower").inertia = 1.1 * np.asarray(spec.body("lower").inertia)
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:] = rng.uniform(-0.5, 0.5, 2)
    levels = rng.uniform(-1.0, 1.0, (round(seconds / HELD), 2)) * PEAK
    found = np.empty((round(seconds / SAMPLE), 6))
    for k, row in enumerate(found):
        data.ctrl[:] = levels[int(k * SAMPLE / HELD + 1e-9)]
        row[:2], row[2:4], row[4:] = data.qpos, data.qvel, data.ctrl
        mujoco.mj_step(model, data, round(SAMPLE / STEP))
    found.setflags(write=False)  # several tests look at the same
    return found, rng.normal(scale=1e-3, size=(len(found), 2))


def write_csv(path: Path, columns: Mapping[str, Array]) -> Path:
    """A table; columns in the order given."""
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = np.column_stack(list(columns.values()))
    lines = [",".join(columns), *(",".join(f"{value:.9g}" for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def plain_logs(folder: Path, count: int = 3, names: Sequence[str] = JOINTS) -> list[Path]:
    """Logs that say what is what: time, <joint>_pos, <joint>_torque."""
    paths = []
    for seed in range(count):
        motion = Motion(seed)
        columns = {"time": motion.time}
        for j, name in enumerate(names):
            columns |= {f"{name}_pos": motion.position[:, j], f"{name}_torque": motion.torque[:, j]}
        paths.append(write_csv(folder / f"log_{seed}.csv", columns))
    return paths


def servo_log(seed: int) -> dict[str, Array]:
    """A log of the machine under a torque kp (r − q) − kv q' at each joint, towards steps r."""
    spec = mujoco.MjSpec.from_string(MJCF)
    for actuator, kp, kv in zip(spec.actuators, (40.0, 15.0), (2.0, 0.6), strict=True):
        actuator.set_to_position(kp=kp, kv=kv)
    model = spec.compile()
    data, rng, rows = mujoco.MjData(model), np.random.default_rng(seed), []
    levels = rng.uniform(-0.8, 0.8, (15, 2))
    for k in range(3000):
        data.ctrl[:] = levels[k // 200]
        rows.append(np.concatenate([[data.time], data.qpos, data.ctrl]))
        mujoco.mj_step(model, data)
    table = np.array(rows)[::2]
    noise = rng.normal(scale=1e-4, size=(len(table), 2))
    names = ("time", "shoulder_pos", "elbow_pos", "shoulder_target", "elbow_target")
    return dict(zip(names, (table + np.column_stack([0 * noise[:, :1], noise, 0 * noise])).T, strict=True))
