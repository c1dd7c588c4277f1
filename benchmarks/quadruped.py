"""Logs of a quadruped that trots on the ground: encoders, IMU and commands, and nothing that tells where it is.

Twelve position-controlled joints and a free trunk, 18 degrees of freedom; the machine's trunk has another mass than its
model's. MuJoCo plays it at a quarter of the model's time step.

python benchmarks/quadruped.py FOLDER
cd FOLDER && dr-lab init quadruped.xml logs/*.csv
"""

import argparse
import json
from pathlib import Path

import mujoco
import numpy as np

MASS, TRUE_MASS = 6.9, 7.9  # kg, of the trunk in the model and in the machine
HIPS = {"FL": (0.19, 0.047), "FR": (0.19, -0.047), "RL": (-0.19, 0.047), "RR": (-0.19, -0.047)}  # m
STEP, SAMPLE, SETTLING = 0.0005, 0.002, 1.0  # s
NOISE = {"q": 5e-4, "gyro": 5e-3, "acc": 5e-2, "quat": 5e-4}  # rad, rad/s, m/s², 1
PARTS = ("hip", "thigh", "calf")
_LEG = """<body name="{name}_hip" pos="{x} {y} 0"><inertial mass="0.68" pos="0 0 0" diaginertia="5e-4 9e-4 6e-4"/>
  <joint name="{name}_hip" axis="1 0 0" range="-0.8 0.8" damping="0.1" armature="0.01"/>
  <body name="{name}_thigh" pos="0 {out} 0">
    <inertial mass="1.15" pos="0 {back} -0.033" diaginertia="5.8e-3 5.5e-3 1e-3"/>
    <joint name="{name}_thigh" axis="0 1 0" range="-1 3" damping="0.1" armature="0.01"/>
    <body name="{name}_calf" pos="0 0 -0.213">
      <inertial mass="0.24" pos="0.005 0 -0.13" diaginertia="1.4e-3 1.4e-3 3e-5"/>
      <joint name="{name}_calf" axis="0 1 0" range="-2.7 -0.8" damping="0.1" armature="0.01"/>
      <geom name="{name}_foot" size="0.022" pos="0 0 -0.213" friction="0.8" contype="1" conaffinity="2"/>
    </body></body></body>"""
_MJCF = """<mujoco model="quadruped"><compiler angle="radian"/>
<option timestep="0.002" integrator="implicitfast" cone="elliptic"/>
<worldbody><geom name="floor" type="plane" size="20 20 0.1" contype="2" conaffinity="1" friction="0.8"/>
  <body name="trunk" pos="0 0 0.32"><freejoint name="base"/>
    <inertial mass="{mass}" pos="0.02 0 0" diaginertia="0.025 0.098 0.107"/>
    <site name="imu"/>{legs}</body></worldbody>
<actuator>{servos}</actuator>
<sensor>{encoders}<gyro name="imu_gyro" site="imu"/><accelerometer name="imu_acc" site="imu"/>
  <framequat name="imu_quat" objtype="site" objname="imu"/></sensor></mujoco>"""


def mjcf(mass: float) -> str:
    """The machine with a mass of its trunk in kg."""
    names = [f"{leg}_{part}" for leg in HIPS for part in PARTS]
    legs = "".join(
        _LEG.format(name=leg, x=x, y=y, out=0.095 * np.sign(y), back=-0.02 * np.sign(y)) for leg, (x, y) in HIPS.items()
    )
    servos = "".join(f'<position name="{n}" joint="{n}" kp="60" kv="1.5" forcerange="-24 24"/>' for n in names)
    encoders = "".join(f'<jointpos name="{n}_q" joint="{n}"/>' for n in names)
    return _MJCF.format(mass=mass, legs=legs, servos=servos, encoders=encoders)


def trot(time: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Commands of all joints, which begin from rest, shape (n, 12): diagonal legs swing together, lifted on the way."""
    rate, size, sway, begin = (
        rng.uniform(1.2, 2.0),
        rng.uniform(0.06, 0.14),
        rng.uniform(-0.03, 0.03),
        np.minimum(time, 1),
    )
    columns = list[np.ndarray]()
    for leg in HIPS:
        phase = 2 * np.pi * rate * time + (0.0 if leg in {"FL", "RR"} else np.pi)
        lifted = np.maximum(np.cos(phase), 0.0)
        columns += [sway * np.sin(0.6 * np.pi * time) * begin, 0.9 + begin * (size * np.sin(phase) + 0.22 * lifted)]
        columns += [-1.8 - begin * 0.44 * lifted]
    return np.stack(columns, axis=1)


def log(seed: int, seconds: float) -> np.ndarray:
    """Rows of time, commands, encoders and IMU of a machine that has settled, shape (n, 35)."""
    rng, time = np.random.default_rng(seed), np.arange(0.0, seconds, SAMPLE)
    commands, model = trot(time, rng), mujoco.MjModel.from_xml_string(mjcf(TRUE_MASS))
    model.opt.timestep = STEP
    data = mujoco.MjData(model)
    data.qpos[2], data.qpos[7:], data.ctrl[:] = 0.29, commands[0], commands[0]
    mujoco.mj_step(model, data, round(SETTLING / STEP))
    rows = list[np.ndarray]()
    for at, command in zip(time, commands, strict=True):
        data.ctrl[:] = command
        mujoco.mj_forward(model, data)
        rows.append(np.concatenate([[at], command, data.sensordata]))
        mujoco.mj_step(model, data, round(SAMPLE / STEP))
    found = np.array(rows)
    noise = np.concatenate(
        [np.zeros(13), *(np.full(n, NOISE[k]) for k, n in (("q", 12), ("gyro", 3), ("acc", 3), ("quat", 4)))]
    )
    found += noise * rng.normal(size=found.shape)
    found[:, 31:] /= np.linalg.norm(found[:, 31:], axis=1, keepdims=True)
    return found


def main() -> None:
    """Write the model and four logs of ten seconds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    (folder / "logs").mkdir(parents=True)
    (folder / "quadruped.xml").write_text(mjcf(MASS), encoding="utf-8")
    joints = [f"{leg}_{part}" for leg in HIPS for part in PARTS]
    imu = [f"{kind}_{axis}" for kind, axes in (("gyro", "xyz"), ("acc", "xyz"), ("quat", "wxyz")) for axis in axes]
    header = ["time", *(f"cmd_{name}" for name in joints), *(f"q_{name}" for name in joints), *imu]
    for seed in range(4):
        rows = log(seed, seconds=10.0)
        np.savetxt(folder / "logs" / f"trot_{seed}.csv", rows, "%.8g", ",", header=",".join(header), comments="")
    print(json.dumps({"folder": str(folder), "trunk_kg": {"model": MASS, "machine": TRUE_MASS}}))


if __name__ == "__main__":
    main()
