"""Fixtures for the tests of the recorders: reports as runs write them, and one log of a small Furuta pendulum."""

import copy
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pyarrow as pa
import pytest
import rerun as rr
from hydra.utils import instantiate
from omegaconf import OmegaConf

from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import Overlay
from dr_lab.trajectory import Array, Signal

__all__ = ["Entities", "close_report", "compare_report", "furuta", "look", "overlay", "read_recording"]

Entities = dict[str, dict[str, list]]

_FURUTA = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <geom name="base" type="box" size="0.05 0.05 0.05" pos="0 0 0.05"/>
    <body name="arm" pos="0 0 0.14">
      <inertial mass="0.095" pos="0.0425 0 0" diaginertia="1e-9 5.7e-5 5.7e-5"/>
      <joint name="arm" axis="0 0 1" damping="1e-4" frictionloss="{friction}"/>
      <geom name="hub" type="cylinder" size="0.012 0.012"/>
      <geom name="rod" type="capsule" size="0.004" fromto="0 0 0 0.085 0 0"/>
      <body name="pole" pos="0.085 0 0">
        <inertial mass="0.024" pos="0 0 -0.0645" diaginertia="3.3e-5 3.3e-5 1e-9"/>
        <joint name="pole" axis="1 0 0" damping="5e-5"/>
        <geom name="rod_2" type="capsule" size="0.00475" fromto="0 0 0 0 0 -0.129"/>
        <geom type="sphere" size="0.008" pos="0 0 -0.129"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor name="motor" joint="arm" gear="0.005"/></actuator>
</mujoco>
"""
_NOISE = 0.0015

_CLOSE: dict[str, Any] = {
    "schema": "dr_lab/gap/1",
    "model": "furuta",
    "measurements": "furuta",
    "verb": "close",
    "verdict": "named",
    "run": "latest",
    "logs": {"fit": ["swing_01", "swing_02"], "held_out": ["swing_05"]},
    "windows": {"length": 0.3, "fit": 66, "held_out": 44, "confirm": 22},
    "noise": {
        "arm.position": {"std": 0.0015, "unit": "rad", "source": "estimated", "numerical": 2.1e-5},
        "pole.position": {"std": 0.0015, "unit": "rad", "source": "given", "numerical": 3.0e-5},
    },
    "as_given": {
        "effects": [],
        "held_out": {
            "chi2": 355.0,
            "rmse": {"arm.position": 0.0611, "pole.position": 0.0404},
            "rmse_predicted": {"arm.position": 0.0712, "pole.position": 0.0501},
        },
        "parameters": {"pole.mass": {"value": 0.024, "std": None, "unit": "kg"}},
    },
    "ladder": [
        {
            "effects": [],
            "held_out": {
                "chi2": 213.4,
                "rmse": {"arm.position": 0.0412, "pole.position": 0.0204},
                "rmse_predicted": {"arm.position": 0.0512, "pole.position": 0.0301},
                "fit_percent": {"arm.position": 71.0, "pole.position": 83.0},
            },
            "parameters": {"pole.mass": {"value": 0.031, "std": 0.001, "unit": "kg"}},
        },
        {
            "effects": ["coulomb_friction@arm"],
            "held_out": {
                "chi2": 1.003,
                "rmse": {"arm.position": 0.00151, "pole.position": 0.0015},
                "rmse_predicted": {"arm.position": 0.00158, "pole.position": 0.00152},
                "fit_percent": {"arm.position": 98.9, "pole.position": 99.1},
            },
            "parameters": {
                "pole.mass": {
                    "value": 0.02613,
                    "std": 0.00012,
                    "unit": "kg",
                    "per_log": {"swing_01": 0.0262, "swing_02": 0.0261},
                },
                "coulomb_friction@arm.torque": {"value": 0.0020031, "std": 1.04e-5, "unit": "N·m"},
            },
        },
    ],
    "ranking": [
        {
            "effect": effect,
            "site": site,
            "held_out_chi2": chi2,
            "gain": gain,
            "gain_ci": [gain - 0.02, gain + 0.02],
            "status": status,
            "parameters": {f"{effect}@{site}.{name}": {"value": value, "std": value / 50, "unit": unit}},
        }
        for effect, site, chi2, gain, status, name, value, unit in [
            ("coulomb_friction", "arm", 1.004, 0.953, "named", "torque", 0.0020031, "N·m"),
            ("stribeck_friction", "arm", 1.31, 0.931, "rejected", "torque", 0.0021, "N·m"),
            ("quadratic_drag", "arm", 9.8, 0.41, "rejected", "drag", 2.1e-5, "N·m·s²/rad²"),
            ("actuator_delay", "motor", 15.2, 0.12, "rejected", "delay", 0.0013, "s"),
            ("payload", "pole", 17.1, 0.02, "not_excited", "mass", 0.001, "kg"),
            ("base_tilt", "world", 17.4, -0.01, "not_excited", "angle", 0.002, "rad"),
        ]
    ],
    "where": [
        {"signal": "arm.position", "region": "|qvel| < 0.3 rad/s", "share": 0.71},
        {"signal": "pole.position", "region": "after a reversal of the arm", "share": 0.083},
    ],
    "next_experiment": {
        "separates": ["coulomb_friction@arm", "stribeck_friction@arm"],
        "sigma": 9.1,
        "command_file": "next_experiment.csv",
    },
    "remaining": {"status": "at_floor", "chi2": 1.003},
    "rungs": [
        {"verdict": "named", "reason": "coulomb_friction@arm lowers the held-out χ² beyond every other candidate."},
        {"verdict": "none", "reason": "The model is at the noise floor.", "effects": ["coulomb_friction@arm"]},
    ],
    "input_correlation": [
        {"signal": s, "command": "motor", "peak_lag": 0.004, "peak": peak, "band": 0.05, "significant": peak > 0.05}
        for s, peak in (("arm.position", 0.31), ("pole.position", 0.01))
    ],
    "clocks": {"swing_05": {"motor": {"clock": "header", "offset": 0.0123, "drift": 2.1e-5, "jitter": 0.0004}}},
    "notes": [
        {"log": "swing_05", "kind": "gap", "signal": "arm.position", "message": "12 samples missing.", "count": 12}
    ],
}


@pytest.fixture
def close_report() -> dict[str, Any]:
    return copy.deepcopy(_CLOSE)


@pytest.fixture
def compare_report(close_report: dict[str, Any]) -> dict[str, Any]:
    same = ("schema", "model", "measurements", "run", "logs", "windows", "noise", "where")
    kept = {key: close_report[key] for key in same} | {"verdict": None, "notes": [], "clocks": {}}
    horizons = [
        {"horizon": h, "rmse": {"arm.position": 0.01 * h, "pole.position": 0.02 * h}} for h in (0.002, 0.3, 5.0)
    ]
    remaining = {"status": "unexplained", "chi2": 355.0}
    return kept | {
        "verb": "compare",
        "ladder": [close_report["as_given"]],
        "horizons": horizons,
        "remaining": remaining,
    }


@pytest.fixture(scope="session")
def look() -> Look:
    conf = Path(__file__).parents[1] / "conf" / "recorder" / "default.yaml"
    return instantiate(OmegaConf.load(conf), _convert_="all")


@pytest.fixture(scope="session")
def furuta() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(_FURUTA.format(friction=0.0))


@pytest.fixture(scope="session")
def overlay(furuta: mujoco.MjModel) -> Overlay:
    """A log of the pendulum with dry friction at the arm, replayed in windows without (before) and with it (after)."""
    random = np.random.default_rng(0)
    real = mujoco.MjModel.from_xml_string(_FURUTA.format(friction=0.002))
    time = np.arange(3000) * real.opt.timestep
    command = 1.2 * np.sin(2 * np.pi * (0.4 + 0.1 * time) * time)
    truth = _replay(real, command, np.array([[0.3, 0.9, 0.0, 0.0]]))
    starts = truth[::500] + random.normal(0.0, 0.5 * _NOISE, (6, 4))
    simulated = {"before": _replay(furuta, command, starts), "after": _replay(real, command, starts)}
    noisy = truth[:, :2] + random.normal(0.0, _NOISE, (3000, 2))
    names = ["arm.position", "pole.position"]
    measured = {name: Signal(name, "rad", time, noisy[:, index]) for index, name in enumerate(names)}
    gap = np.where(np.arange(3000) % 500 == 499, np.nan, 0.0)
    channels = {
        role: {name: state[:, index] + gap for index, name in enumerate(names)} for role, state in simulated.items()
    }
    residuals = {role: noisy - state[:, :2] for role, state in simulated.items()}
    return Overlay(
        log="swing:2",
        time=time,
        poses={role: _poses(furuta, state) for role, state in {"measured": truth, **simulated}.items()},
        measured=measured,
        simulated=channels,
        residual_velocity={
            joint: (truth[:, 2 + index], {role: value[:, index] for role, value in residuals.items()})
            for index, joint in enumerate(["arm", "pole"])
        },
        commands={"motor": Signal("motor", "V", time[::2], command[::2])},
        noise=dict.fromkeys(names, _NOISE),
        residual_names=dict.fromkeys(("arm", "pole"), "position residual [rad]"),
    )


def read_recording(path: Path) -> Entities:
    """Entity → column → values in the file's order; times in s."""
    found: Entities = {}
    for chunk in rr.chunk.RrdReader(path).stream():
        columns = found.setdefault(chunk.entity_path, {})
        batch = chunk.to_record_batch()
        for name, values in zip(batch.schema.names, batch.columns, strict=True):
            is_time = pa.types.is_duration(values.type)
            plain = (values.cast(pa.int64()).to_numpy() / 1e9).tolist() if is_time else values.to_pylist()
            columns.setdefault(name, []).extend(plain)
    return found


def _replay(model: mujoco.MjModel, command: Array, starts: Array) -> Array:
    """States (position, velocity) at each step, started anew from each of `starts` at even spacing."""
    data = mujoco.MjData(model)
    states = np.empty((len(command), 2 * model.nv))
    window = len(command) // len(starts)
    for step, control in enumerate(command):
        if step % window == 0:
            data.qpos[:], data.qvel[:] = np.split(starts[step // window], 2)
        states[step] = np.concatenate([data.qpos, data.qvel])
        data.ctrl[:] = control
        mujoco.mj_step(model, data)
    return states


def _poses(model: mujoco.MjModel, states: Array) -> tuple[Array, Array]:
    data = mujoco.MjData(model)
    position, quaternion = np.empty((len(states), model.nbody, 3)), np.empty((len(states), model.nbody, 4))
    for row, state in enumerate(states):
        data.qpos[:] = state[: model.nq]
        mujoco.mj_kinematics(model, data)
        position[row], quaternion[row] = data.xpos, data.xquat
    return position, quaternion
