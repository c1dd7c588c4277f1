"""Makes logs/ with plain MuJoCo: a machine that stands for yours, with what its drawing does not show."""

from pathlib import Path

import mujoco
import numpy as np

HERE = Path(__file__).parent
RUNS, SECONDS, RATE = 5, 6.0, 250.0  # runs; s of each; samples a second
STEPS = 64  # of the simulation in a sample: a machine has none, and 8 move the elbow by three times its noise
NOISE = 1.0e-3  # rad, of the encoders


def machine() -> mujoco.MjModel:
    """The drawing's arm with other masses and dampings, and with dry friction at the elbow."""
    spec = mujoco.MjSpec.from_file(str(HERE / "mine/model/rig.xml"))
    spec.option.timestep = 1.0 / (RATE * STEPS)
    spec.geom("upper").mass, spec.geom("lower").mass = 0.86, 0.37  # kg; drawn: 0.8 and 0.4
    shoulder, elbow = spec.joint("shoulder"), spec.joint("elbow")
    shoulder.damping[0], elbow.damping[0] = 0.06, 0.015  # N m s/rad; drawn: 0.05 and 0.02
    elbow.frictionloss = 0.05  # N m; not drawn
    elbow.solref_friction = [4 * spec.option.timestep, 1.0]
    return spec.compile()


def run(model: mujoco.MjModel, rng: np.random.Generator) -> np.ndarray:
    """Rows of t, shoulder, elbow and both torques under sines of random frequency."""
    data, rows = mujoco.MjData(model), []
    frequency, phase = rng.uniform(0.3, 1.5, (2, 2)), rng.uniform(0.0, 6.3, (2, 2))  # Hz; rad
    size = np.array([1.2, 0.3]) * rng.uniform(0.7, 1.0)  # N m
    for k in range(round(SECONDS * RATE)):
        t = k / RATE
        torque = size * np.sin(2 * np.pi * frequency * t + phase).sum(1)
        rows.append([t, *(data.qpos + NOISE * rng.standard_normal(2)), *torque])
        data.ctrl[:] = torque
        mujoco.mj_step(model, data, STEPS)
    return np.array(rows)


if __name__ == "__main__":
    arm, draws = machine(), np.random.default_rng(0)
    for number in range(1, RUNS + 1):
        path = HERE / f"logs/run_{number}.csv"
        np.savetxt(path, run(arm, draws), "%.6g", ",", header="t,shoulder,elbow,tau_shoulder,tau_elbow", comments="")
