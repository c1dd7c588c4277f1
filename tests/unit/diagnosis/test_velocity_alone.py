"""Joints of which only the velocity is logged, as of wheels: what laws remember, and where windows begin."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_machines import log_of, model_of, simulated, solver_settings, steps_command, windows_of
from effect_machines import placed, scales_of

from dr_lab.diagnosis.experiment import readings
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.physics.model import Model

STEP, NOISE = 0.002, 0.02  # s, rad/s
WHEEL = f"""<mujoco model="wheel"><compiler angle="radian"/>
  <option timestep="{STEP}" integrator="implicitfast" gravity="0 0 0"/>
  <worldbody><body name="rod"><inertial mass="1" pos="0 0 0" diaginertia=".02 .02 .02"/>
    <joint name="hinge" axis="0 1 0" damping="0.05"/></body></worldbody>
  <actuator><motor name="drive" joint="hinge"/></actuator></mujoco>"""


def wheel(name: str, **values: float) -> tuple[Model, np.ndarray]:
    base = model_of(WHEEL)
    one = placed(base, name, "hinge", scales_of(base, torque=1.0, speed=10.0, position=100.0))
    model = base.with_effect(one)
    return model, model.space.vector({f"{one.label}.{key}": value for key, value in values.items()})


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("flexible_mode", {"inertia": 0.01, "period": 0.25, "damping": 0.05}),
        ("hysteresis", {"torque": 0.3, "displacement": 0.3}),
        ("presliding_friction", {"torque": 0.3, "displacement": 0.3, "creep": 0.05}),
    ],
)
def test_laws_remember_the_motion_of_before_a_window(effect: str, values: dict[str, float]) -> None:
    """They err no more than where the position is logged; with a memory at rest they did by 0.3 to 6 rad/s."""
    model, z = wheel(effect, **values)
    time, command = STEP * np.arange(3000.0), steps_command("drive", 1.0, 6.0, 1, period=1.0)
    command = replace(command, value=0.6 + 0.3 * command.value)
    seen = readings(model, z, np.zeros(1), {"drive": command}, ["hinge.velocity"], time)["hinge.velocity"][:, 0]
    windows = windows_of(model, [log_of("a", {"hinge.velocity": (time, seen)}, command)], noise=1e-3)
    replay = Replay(model, windows, 1)
    tape, _ = replay.simulate(z[None], np.zeros((1, len(windows), replay.nstate)))
    found, begin = tape.qvel[0, :, :, 0], np.rint(windows.begin / STEP).astype(int)
    true = np.stack([seen[k : k + found.shape[1]] for k in begin])
    missed = np.abs((found - found[:, :1]) - (true - true[:, :1])).max(axis=1)
    assert np.median(missed) < 0.02
    assert np.abs(windows.before.qvel).mean() == pytest.approx(np.abs(seen).mean(), rel=0.1)
    np.testing.assert_allclose(windows.before.qpos[:, -1, 0], -0.5 * STEP * true[:, 0], atol=2e-3)


@pytest.mark.parametrize(
    ("effect", "excess", "late"), [("sensor_scale", 0.15, 0.0), ("sensor_time_offset", 0.0, 0.015)]
)
def test_a_start_is_where_its_reading_is_the_measured_one(effect: str, excess: float, late: float) -> None:
    logs = []
    for seed in range(3):
        command = steps_command("drive", 1.0, 6.0, seed, period=0.5)
        command = replace(command, value=command.value + 0.8)
        motion = simulated(model_of(WHEEL).nominal(), command, 6.0)
        read = (1 + excess) * motion["qvel"][:, 0] + NOISE * np.random.default_rng(seed).normal(
            size=len(motion["time"])
        )
        logs.append(log_of(f"log_{seed}", {"hinge.velocity": (motion["time"] + late, read)}, command))
    model, _ = wheel(effect)
    replay = Replay(model, windows_of(model, logs, noise=NOISE), 1)
    found = Fitter(replay, solver_settings()).run(model.space.nominal)
    assert found.z[0] == pytest.approx(excess + late, rel=2e-3)
    assert found.cost / replay.fitted.sum() == pytest.approx(1.0, abs=0.05)
