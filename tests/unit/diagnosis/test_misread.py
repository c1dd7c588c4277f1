"""Channels of a cart with a pole that are declared in another unit, or exchanged, are told with what they are."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pytest
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.diagnosis.faults.data_faults import Fault
from dr_lab.diagnosis.faults.fault_settings import FaultSettings
from dr_lab.physics.model import Model, from_spec
from dr_lab.trajectory import Log, MeasurementSet, Noise, Signal
from tests.diagnosis_machines import suspected

STEP, LENGTH, PEAK, DEGREE = 0.002, 8.0, 12.0, np.pi / 180
UNITS = {"rail.position": "m", "pivot.position": "rad"}
CART = """<mujoco><option timestep="0.002" integrator="RK4"/><worldbody><body name="cart">
  <inertial pos="0 0 0" mass="{mass}" diaginertia="0.01 0.01 0.01"/>
  <joint name="rail" type="slide" axis="1 0 0" damping="2" {rail}/>
  <body name="pole"><inertial pos="0 0 -0.21" mass="0.25" diaginertia="0.004 0.004 0.0002"/>
    <joint name="pivot" axis="0 -1 0" damping="0.002"/></body></body></worldbody>
  <actuator><motor name="motor" joint="rail" ctrlrange="-15 15"/></actuator></mujoco>"""


@cache
def settings() -> FaultSettings:
    return instantiate(compose("close", ["effect=spring"]).faults, _convert_="all")


def nominal() -> Model:
    return from_spec("cart", mujoco.MjSpec.from_string(CART.format(mass=1.2, rail="")), {})


def driven(seed: int) -> Log:
    """A log of a cart that is 10 % lighter than the model's and has dry friction."""
    model = mujoco.MjModel.from_xml_string(CART.format(mass=1.1, rail='frictionloss="0.8"'))
    data, rng, time = mujoco.MjData(model), np.random.default_rng(seed), np.arange(0.0, LENGTH, STEP)
    rates, phases = rng.uniform(0.2, 2.0, 4), rng.uniform(0, 2 * np.pi, 4)
    sent = np.sin(2 * np.pi * rates * time[:, None] + phases).sum(1)
    sent, path = PEAK * sent / np.abs(sent).max(), np.empty((len(time), 2))
    for k in range(len(time)):
        path[k], data.ctrl[:] = data.qpos, sent[k]
        mujoco.mj_step(model, data)
    path += rng.normal(scale=1e-4, size=path.shape)
    outputs = {name: Signal(name, unit, time, path[:, i]) for i, (name, unit) in enumerate(UNITS.items())}
    return Log(f"log_{seed}", outputs, {"motor": Signal("motor", "N", time, sent)})


@cache
def sound() -> MeasurementSet:
    logs = [driven(seed) for seed in (1, 2, 3)]
    noise = {name: Noise(1e-4, unit, "estimated") for name, unit in UNITS.items()}
    return MeasurementSet("cart", tuple(logs[:2]), tuple(logs[2:]), noise, dict.fromkeys((*UNITS, "motor"), 0.02))


def told(change: Callable[[Log], Log]) -> tuple[Fault, ...]:
    parts = {part: tuple(map(change, getattr(sound(), part))) for part in ("fit", "held_out")}
    return suspected(nominal(), replace(sound(), **parts), settings())


def times(signals: Mapping[str, Signal], name: str, factor: float) -> dict[str, Signal]:
    return {**signals, name: replace(signals[name], value=factor * signals[name].value)}


def test_logs_as_declared_raise_nothing() -> None:
    assert told(lambda log: log) == ()


@pytest.mark.parametrize(
    ("name", "factor", "words", "remedy"),
    [
        (
            "pivot.position",
            DEGREE,
            "pivot.position seems to be in rad and called deg",
            "is deg, write rad; else multiply its scale by 57.3",
        ),
        (
            "pivot.position",
            1 / DEGREE,
            "pivot.position seems to be in deg and called rad",
            "is rad, write deg; else multiply its scale by 0.01745",
        ),
        (
            "rail.position",
            1e-3,
            "rail.position seems to be in m and called mm",
            "in measurements.outputs.rail.position is mm, write m; else multiply its scale by 1000",
        ),
        (
            "rail.position",
            1e3,
            "rail.position seems to be in mm and called m",
            "in measurements.outputs.rail.position is m, write mm; else multiply its scale by 0.001",
        ),
    ],
)
def test_positions_in_another_unit_are_told_with_theirs(name: str, factor: float, words: str, remedy: str) -> None:
    """And nothing is said of the commands, which no longer fit the motion either."""
    faults = told(lambda log: replace(log, outputs=times(log.outputs, name, factor)))
    assert [(fault.kind, fault.log, fault.signal) for fault in faults] == [
        ("unit", f"log_{k}", name) for k in (1, 2, 3)
    ]
    assert words in faults[0].message
    assert remedy in faults[0].remedy


def test_a_force_in_newtons_that_is_called_kilogram_force_is_told_of_all_logs() -> None:
    """Most of such commands are cut at the actuator's range, so that no gain of what is left explains the motion."""
    faults = told(lambda log: replace(log, commands=times(log.commands, "motor", 9.80665)))
    assert [(fault.kind, fault.log, fault.signal) for fault in faults] == [
        ("unit", f"log_{k}", "motor") for k in (1, 2, 3)
    ]
    assert "newton (N called kgf)" in faults[0].message
    assert "N·m" not in faults[0].message


def test_exchanged_columns_are_told() -> None:
    def exchanged(log: Log) -> Log:
        rail, pivot = log.outputs["rail.position"], log.outputs["pivot.position"]
        swapped = {
            "rail.position": replace(rail, value=pivot.value),
            "pivot.position": replace(pivot, value=rail.value),
        }
        return replace(log, outputs=swapped)

    faults = told(exchanged)
    assert [(fault.kind, fault.log) for fault in faults] == [("swapped", f"log_{k}") for k in (1, 2, 3)]
    assert "rail.position and pivot.position seem to be exchanged" in faults[0].message


PAN_TILT = """<mujoco><option timestep="0.002"/><worldbody><body><joint name="one" axis="0 0 1" damping="0.05"/>
  <inertial pos="0 0 0" mass="0.5" diaginertia="0.01 0.01 0.01"/>
  <body><joint name="two" axis="0 1 0" damping="0.05"/>
  <inertial pos="0.05 0 0.02" mass="0.4" diaginertia="0.004 0.004 0.004"/></body></body></worldbody>
  <actuator>{}</actuator></mujoco>"""
SWINGING = """<mujoco><option timestep="0.002"/><worldbody><body><joint name="one" axis="0 1 0" damping="0.05"/>
  <geom type="capsule" fromto="0 0 0 0 0 -0.35" size="0.03" mass="1.5" contype="0" conaffinity="0"/>
  <body pos="0 0 -0.35"><joint name="two" axis="0 1 0" damping="0.05"/>
  <geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.025" mass="0.8" contype="0" conaffinity="0"/></body></body>
  </worldbody><actuator>{}</actuator></mujoco>"""
SERVO, MOTOR = '<position name="{0}" joint="{0}" kp="3" kv="0.3"/>', '<motor name="{0}" joint="{0}"/>'


@pytest.mark.parametrize(
    ("machine", "drive", "size"),
    [
        pytest.param(PAN_TILT, SERVO, 0.3, id="servos"),
        pytest.param(PAN_TILT, MOTOR, 0.3, id="motors"),
        pytest.param(SWINGING, MOTOR, 0.8, id="motors whose torques are a small part of all forces"),
    ],
)
def test_commands_of_two_joints_that_are_exchanged_are_told(machine: str, drive: str, size: float) -> None:
    spec = mujoco.MjSpec.from_string(machine.format(drive.format("one") + drive.format("two")))
    model, time = spec.compile(), np.arange(0.0, 6.0, STEP)
    data, path = mujoco.MjData(model), np.empty((len(time), 2))
    sent = size * np.stack([np.sin(5 * time), np.sin(3.3 * time + 1) + np.sin(8 * time)], axis=1)
    for k, now in enumerate(sent):
        path[k], data.ctrl[:] = data.qpos, now
        mujoco.mj_step(model, data)
    path += np.random.default_rng(1).normal(scale=1e-4, size=path.shape)
    unit, joints = "rad" if drive is SERVO else "N·m", ("one", "two")
    outputs = {f"{n}.position": Signal(f"{n}.position", "rad", time, path[:, i]) for i, n in enumerate(joints)}
    for names, kinds in ((joints, []), (joints[::-1], ["swapped"])):
        commands = {name: Signal(name, unit, time, sent[:, i]) for i, name in enumerate(names)}
        log, age = Log("log", outputs, commands), dict.fromkeys((*outputs, *commands), 0.02)
        faults = suspected(from_spec("it", spec, {}), MeasurementSet("it", (log,), (), {}, age), settings())
        assert [fault.kind for fault in faults] == kinds
    assert "the commands of one and two seem to be exchanged" in faults[0].message


def test_a_slide_alone_leaves_open_whether_its_place_or_its_force_is_misread() -> None:
    """Millimetres called metres, and newtons called millinewtons, ask for the same thousandfold force."""
    carriage = """<mujoco><worldbody><body name="carriage"><inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/>
      <joint name="rail" type="slide" axis="1 0 0" damping="2"/></body></worldbody>
      <actuator><motor name="motor" joint="rail"/></actuator></mujoco>"""
    spec, time = mujoco.MjSpec.from_string(carriage), np.arange(0.0, 4.0, STEP)
    place = 0.3 * np.sin(4 * time) + 0.1 * np.sin(9 * time)
    rate, force = 1.2 * np.cos(4 * time) + 0.9 * np.cos(9 * time), -4.8 * np.sin(4 * time) - 8.1 * np.sin(9 * time)
    outputs = {"rail.position": Signal("rail.position", "m", time, 1e3 * place)}
    log = Log("log", outputs, {"motor": Signal("motor", "N", time, 2 * force + 2 * rate)})
    measured = MeasurementSet("carriage", (log,), (), {}, dict.fromkeys(("rail.position", "motor"), 0.02))
    (fault,) = suspected(from_spec("carriage", spec, {}), measured, settings())
    assert (fault.kind, fault.signal) == ("unit", "motor")
    assert "near 1000: kilo (N called mN" in fault.message
    assert "Or rail.position is in mm and called m: write its unit in measurements.outputs." in fault.remedy
