"""Logs of an IMU, of an orientation and of a machine that is told positions, replayed by the model that made them."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_machines import (
    NOISE,
    STEP,
    formal_std,
    log_of,
    model_of,
    simulated,
    solver_settings,
    true_starts,
    windows_of,
)
from effect_machines import catalogue_effect, placed

from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import fit_states
from dr_lab.errors import DataError
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array, Log, Signal

ARM = f"""<mujoco model="arm">
  <compiler angle="radian"/>
  <option timestep="{STEP}" integrator="RK4"/>
  <worldbody><body name="upper">
    <inertial mass="0.5" pos="0 0 -0.3" diaginertia="0.005 0.004 0.001"/>
    <joint name="hinge" axis="0 1 0" damping="0.05"/><joint name="roll" axis="1 0 0" damping="0.05"/>
    <site name="imu" pos="0.05 0 -0.4" euler="0.3 0.2 0.1"/>
  </body></worldbody>
  <actuator><position name="drive" joint="hinge" kp="8" kv="0.4"/></actuator>
  <sensor>
    <gyro name="gyro" site="imu"/><accelerometer name="acceleration" site="imu"/>
    <framequat name="pose" objtype="site" objname="imu"/>
  </sensor>
</mujoco>"""
DAMPING = {"hinge.damping": {"target": "joint.hinge.damping", "unit": "N·m·s/rad", "low": 0.0, "high": 0.5}}
SLICES = {"sensor.gyro": slice(0, 3), "sensor.acceleration": slice(3, 6), "sensor.pose": slice(6, 10)}


def target() -> Signal:
    time = np.arange(0.0, 3.0, 0.08)
    return Signal("drive", "rad", time, np.random.default_rng(0).uniform(-0.8, 0.8, len(time)))


def motion_of(damping: float = 0.05, refine: int = 1) -> dict[str, Array]:
    compiled = model_of(ARM, DAMPING).compile(np.array([damping]))
    compiled.opt.timestep /= refine
    return simulated(compiled, target(), 3.0, qpos=[0.5, 0.3])


def log(motion: dict[str, Array], late: float = 0.0, noise: float = 0.0, start: int = 0, every: int = 1) -> Log:
    """Joint positions, and every sensor stamped `late`; a step's call leaves the sensors of the step's beginning."""
    rng, time = np.random.default_rng(1), motion["time"]
    joints = {"hinge.position": motion["qpos"][:, 0], "roll.position": motion["qpos"][:, 1]}
    sensors = {name: motion["sensordata"][:, part] for name, part in SLICES.items()}
    read = {n: (time, v) for n, v in joints.items()} | {n: (time + late, v) for n, v in sensors.items()}
    picked = {n: (t[start::every], v[start::every]) for n, (t, v) in read.items()}
    return log_of("a", {n: (t, v + noise * rng.normal(size=v.shape)) for n, (t, v) in picked.items()}, target())


def worst(model: Model, z: Array, measured: Log) -> dict[str, float]:
    """Largest residual of each channel, in its unit, from the true starts."""
    replay = Replay(model, windows_of(model, [measured]), 1)
    found, _ = replay.residuals(z[None], true_starts(replay, z, motion_of())[None])
    return {s.channel.name: float(np.abs(r[s.scored]).max()) * s.std for s, r in replay.by_channel(found[0])}


def test_sensors_are_those_of_the_step_s_beginning() -> None:
    found = worst(model_of(ARM), np.zeros(0), log(motion_of()))
    assert set(found) == {"hinge.position", "roll.position", *SLICES}
    assert max(found.values()) < 1e-6


def test_sensors_stamped_after_the_step_are_one_step_late() -> None:
    late = log(motion_of(), late=STEP)
    plain = worst(model_of(ARM), np.zeros(0), late)
    assert plain["sensor.gyro"] > 0.05
    assert plain["sensor.pose"] > 0.005
    model = model_of(ARM)
    for name in SLICES:
        model = model.with_effect(placed(model, "sensor_time_offset", name))
    z = model.space.vector({f"sensor_time_offset@{name}.offset": STEP for name in SLICES})
    assert max(worst(model, z, late).values()) < 1e-6


def test_between_steps_smooth_sensors_are_interpolated() -> None:
    halves = log(motion_of(refine=2), start=1, every=2)
    found = worst(model_of(ARM), np.zeros(0), halves)
    del found["sensor.acceleration"]  # jumps with the command
    assert max(found.values()) < 2e-3  # rad/s, rad
    assert found["sensor.pose"] < 2e-4


def test_an_orientation_s_sign_is_of_no_account() -> None:
    motion = motion_of()
    motion["sensordata"][::3, SLICES["sensor.pose"]] *= -1.0
    assert worst(model_of(ARM), np.zeros(0), log(motion))["sensor.pose"] < 1e-6


def test_starts_and_a_damping_are_found_from_an_imu_under_position_targets() -> None:
    model = model_of(ARM, DAMPING)
    measured = log(motion_of(0.08), noise=NOISE)
    windows = windows_of(model, [measured])
    _, states = fit_states(model, np.array([0.08]), windows, solver_settings(), 1)
    assert states.cost / sum(s.scored.sum() * s.channel.size for s in windows.samples) == pytest.approx(1.0, abs=0.05)
    fit = Fitter(Replay(model, windows, 1), solver_settings()).run(model.space.nominal)
    (std,) = formal_std(model, fit)
    assert std < 2e-4
    assert abs(fit.z[0] - 0.08) < 4 * std


def test_an_imu_alone_shows_a_start_that_no_joint_sensor_does() -> None:
    model, motion = model_of(ARM), motion_of()
    only = {n: s for n, s in log(motion, noise=NOISE).outputs.items() if n in ("sensor.gyro", "sensor.pose")}
    windows = windows_of(model, [replace(log(motion), outputs=only)])
    replay, fit = fit_states(model, np.zeros(0), windows, solver_settings(), 1)
    tape, _ = replay.simulate(fit.z[None], fit.delta[None])
    step = np.rint(windows.begin / STEP).astype(int)
    np.testing.assert_allclose(tape.qpos[0, :, 0], motion["qpos"][step], atol=5 * NOISE)
    np.testing.assert_allclose(tape.qvel[0, :, 0], motion["qvel"][step], atol=0.02)


ONE = "sensor.gyro.y"


def one_axis(motion: dict[str, Array], late: float = 0.0) -> Log:
    """Joints, and the rate about one axis of the IMU."""
    whole = log(motion)
    rate = Signal(ONE, "rad/s", motion["time"] + late, motion["sensordata"][:, 1])
    joints = {name: signal for name, signal in whole.outputs.items() if name not in SLICES}
    return replace(whole, outputs={**joints, ONE: rate})


def test_a_log_may_hold_one_axis_of_a_sensor() -> None:
    found = worst(model_of(ARM), np.zeros(0), one_axis(motion_of()))
    assert set(found) == {"hinge.position", "roll.position", ONE}
    assert max(found.values()) < 1e-6


def test_one_axis_of_a_sensor_may_be_late_or_biased() -> None:
    model = model_of(ARM)
    model = model.with_effect(placed(model, "sensor_time_offset", ONE)).with_effect(placed(model, "sensor_bias", ONE))
    late = one_axis(motion_of(), late=STEP)
    biased = replace(late, outputs={**late.outputs, ONE: replace(late.outputs[ONE], value=late.outputs[ONE].value + 1)})
    z = model.space.vector({f"sensor_time_offset@{ONE}.offset": STEP, f"sensor_bias@{ONE}.bias": 1.0})
    assert max(worst(model, z, biased).values()) < 1e-6


def test_effects_of_sensors_are_looked_for_where_the_logs_hold_them() -> None:
    compiled, bias = model_of(ARM).nominal(), catalogue_effect("sensor_bias")
    assert {ONE, "sensor.acceleration.z", "hinge"} <= set(bias.sites(compiled))
    assert "sensor.gyro" not in bias.sites(compiled)  # three numbers
    shown = [site for site in bias.sites(compiled) if bias.shown_by(site, [ONE, "hinge.position"])]
    assert shown == ["hinge", "roll", ONE]


def test_too_few_numbers_for_a_sensor_are_told() -> None:
    whole = log(motion_of())
    first = replace(whole.outputs["sensor.gyro"], value=whole.outputs["sensor.gyro"].value[:, 0])
    with pytest.raises(
        DataError, match=r"sensor\.gyro has 3 numbers, one of the log 1\. .*sensor\.gyro\.x, \.y or \.z"
    ):
        windows_of(model_of(ARM), [replace(whole, outputs={**whole.outputs, "sensor.gyro": first})])
