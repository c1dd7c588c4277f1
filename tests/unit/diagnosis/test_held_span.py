"""A joint that is held at a log's beginning or end is told, one that rests by itself is not."""

from functools import cache

import mujoco
import numpy as np
import pytest
from diagnosis_machines import clock, fault_settings, suspected

from dr_lab.diagnosis.faults.data_faults import Fault
from dr_lab.physics.model import from_spec
from dr_lab.trajectory import Array, Log, MeasurementSet, Noise, Signal

STEP, LENGTH, START, NOISE = 0.002, 5.0, 0.8, 1e-3
XML = """<mujoco><compiler angle="radian"/><option timestep="0.002" integrator="RK4"/><worldbody><body name="rod">
  <joint name="hinge" axis="0 1 0" damping="0.01" frictionloss="{friction}"/>
  <inertial pos="0 0 -0.3" mass="{mass}" diaginertia="0.005 0.005 0.001"/></body></worldbody></mujoco>"""


@cache
def swing(friction: float = 0.0) -> Array:
    """Angles of a pendulum that begins to move at `START` rad."""
    model = mujoco.MjModel.from_xml_string(XML.format(mass=0.5, friction=friction))
    data = mujoco.MjData(model)
    data.qpos[0] = START
    path = np.empty(round(LENGTH / STEP))
    for k in range(len(path)):
        path[k] = data.qpos[0]
        mujoco.mj_step(model, data)
    return path


def faults(path: Array, friction: float = 0.0, actuator: str = "") -> tuple[Fault, ...]:
    """What a model whose mass is 15 % too small says to a log."""
    noise = np.random.default_rng(0).normal(0.0, NOISE, len(path))
    angle = Signal("hinge.position", "rad", clock(len(path), STEP), path + noise)
    log = Log("log", {"hinge.position": angle}, {})
    known = {"hinge.position": Noise(NOISE, "rad", "given")}
    measured = MeasurementSet("rod", (log,), (), known, {"hinge.position": 0.02})
    text = XML.format(mass=0.425, friction=friction).replace("</mujoco>", f"<actuator>{actuator}</actuator></mujoco>")
    model = from_spec("rod", mujoco.MjSpec.from_string(text), {})
    return suspected(model, measured, fault_settings())


def test_a_pendulum_that_is_let_go_was_held_before() -> None:
    (found,) = faults(np.concatenate([np.full(300, START), swing()]))
    assert (found.kind, found.log, found.signal) == ("held", "log", "hinge")
    assert found.begin < 0.1
    assert found.end == pytest.approx(0.6, abs=0.06)
    assert found.message.startswith("hinge rests although 0.9 N·m")  # 0.425·9.81·0.3·sin 0.8
    assert "log[0.6:]" in found.remedy or "log[0.7:]" in found.remedy


def test_a_pendulum_that_is_caught_was_held_behind() -> None:
    path = swing()
    turn = int(np.argmin(path[: round(1.2 / STEP)])) + 1000  # at rest at the other side, one period or so later
    caught = 1 + int(np.argmax(np.abs(path[turn:])))
    path = np.concatenate([path[: turn + caught], np.full(400, path[turn + caught])])
    (found,) = faults(path)
    assert found.kind == "held"
    assert found.begin == pytest.approx(STEP * (turn + caught), abs=0.15)
    assert "log[:" in found.remedy


def test_what_swings_from_the_first_sample_on_was_not_held() -> None:
    assert faults(swing()) == ()


def test_what_hangs_down_before_it_is_pushed_was_not_held() -> None:
    push = np.concatenate([np.zeros(400), swing()[np.flatnonzero(np.diff(np.sign(swing())))[0] + 1 :]])
    assert faults(push) == ()


@pytest.mark.parametrize("known", [0.0, 0.15, 0.3])
def test_what_friction_brings_to_rest_off_its_lowest_place_was_not_held(known: float) -> None:
    path = swing(friction=0.3)
    assert abs(path[-1]) > 0.05  # N·m·rad: gravity there is what 0.3 N·m hold
    assert np.ptp(path[-500:]) < 5e-3  # MuJoCo's friction creeps
    assert faults(path, known) == ()


def test_what_an_actuator_may_hold_whose_commands_are_not_logged_is_not_told() -> None:
    path = np.concatenate([np.full(300, START), swing()])
    assert faults(path, actuator='<position name="servo" joint="hinge" kp="50"/>') == ()


def test_a_short_rest_is_not_told() -> None:
    assert faults(np.concatenate([np.full(100, START), swing()])) == ()


def test_what_rests_until_it_is_driven_was_not_held_though_the_drive_is_weaker_than_its_model_says() -> None:
    """A constant then takes the place of what the drive lacks, and would move it at rest, where nothing acts."""
    thrust = "<motor name='thrust' joint='hinge' gear='{gear}'/>"
    xml = XML.format(mass=0.5, friction=0.0).replace("</mujoco>", f"<actuator>{thrust}</actuator></mujoco>")
    truth = mujoco.MjModel.from_xml_string(xml.format(gear=0.7))
    data, count = mujoco.MjData(truth), round(2 * LENGTH / STEP)
    path, command = np.zeros(count), np.where(np.arange(count) < 0.1 * count, 0.0, 0.8)
    for k in range(count):
        path[k], data.ctrl[0] = data.qpos[0], command[k]
        mujoco.mj_step(truth, data)
    noise, time = np.random.default_rng(0).normal(0.0, NOISE, count), clock(count, STEP)
    log = Log(
        "log",
        {"hinge.position": Signal("hinge.position", "rad", time, path + noise)},
        {"thrust": Signal("thrust", "1", time, command)},
    )
    measured = MeasurementSet(
        "rod", (log,), (), {"hinge.position": Noise(NOISE, "rad", "given")}, {"hinge.position": 0.02}
    )
    model = from_spec("rod", mujoco.MjSpec.from_string(xml.format(gear=1.0)), {})
    assert not [fault for fault in suspected(model, measured, fault_settings()) if fault.kind == "held"]
