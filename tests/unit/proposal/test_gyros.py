"""A pan-tilt head with a gyroscope on its camera: what turns tells signs, units and zeros before any force does."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hydra.utils import instantiate
from own_robot import write_csv

from dr_lab.cli.compose import compose
from dr_lab.physics.compiling import compiled
from dr_lab.proposal.gyros import rates
from dr_lab.proposal.propose import Proposal, propose
from dr_lab.proposal.robot import read_robot
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.survey import survey
from dr_lab.proposal.zeros import felt_zeros
from dr_lab.trajectory import Array

HEAD = """<mujoco model="head"><compiler angle="radian"/><option timestep="0.001" integrator="implicitfast"/><worldbody>
  <body name="yoke"><inertial pos="0 0 0.03" mass="0.9" diaginertia="0.0022 0.0018 0.0020"/>
    <joint name="pan" axis="0 0 1" damping="0.03"/>
    <body name="camera" pos="0 0 0.07"><inertial pos="0.035 0 0.012" mass="0.7" diaginertia="0.0006 0.0011 0.001"/>
      <joint name="tilt" axis="0 -1 0" damping="0.02" frictionloss="0" stiffness="0"/><site name="imu"/></body>
  </body></worldbody>
  <actuator><motor name="pan" joint="pan"/><motor name="tilt" joint="tilt"/></actuator>
  <sensor><gyro name="gyro" site="imu"/></sensor></mujoco>"""
DEAF = HEAD.replace('<sensor><gyro name="gyro" site="imu"/></sensor>', "")
FRICTION = HEAD.replace('frictionloss="0"', 'frictionloss="0.02"')
CABLE = HEAD.replace('stiffness="0"', 'stiffness="0.6" springref="-0.5"')
BALANCED = HEAD.replace('pos="0.035 0 0.012"', 'pos="0 0 0"')
RATE, SAMPLE, SECONDS = 200.0, 0.005, 4.0  # Hz, s, s
NOISE = (5e-4, 3e-3)  # rad, rad/s


@cache
def moved(xml: str, seed: int) -> tuple[Array, Array, Array]:
    """Angles, rates and torques of a head that follows sines, every 5 ms."""
    model, rng = mujoco.MjModel.from_xml_string(xml), np.random.default_rng(seed)
    model.opt.timestep = 5e-4
    data, rows = mujoco.MjData(model), []
    rate, phase = rng.uniform(0.25, 0.9, (2, 3)), rng.uniform(0, 2 * np.pi, (2, 3))
    for k in range(round(SECONDS / SAMPLE)):
        wanted = (np.array([[0.5, 0.3, 0.15], [0.35, 0.2, 0.1]]) * np.sin(2 * np.pi * rate * k * SAMPLE + phase)).sum(1)
        data.ctrl[:] = (3.0, 2.5) * (min(k * SAMPLE / 0.5, 1.0) * wanted + (0.0, 0.1) - data.qpos) - 0.1 * data.qvel
        mujoco.mj_forward(model, data)
        rows.append(np.concatenate([data.qpos, data.sensor("gyro").data, data.ctrl]))
        mujoco.mj_step(model, data, round(SAMPLE / model.opt.timestep))
    table = np.array(rows)
    table[:, :5] += rng.normal(size=(len(table), 5)) * np.repeat(NOISE, (2, 3))
    return table[:, :2], table[:, 2:5], table[:, 5:]


def same(values: Array) -> Array:
    return values


@cache
def settings() -> ProposalSettings:
    return instantiate(compose("init", ["robot=it", "logs=[it]"]).proposal)


def proposed(
    truth: str,
    place: Callable[[Array], Array] = same,
    turn: Callable[[Array], Array] = same,
    robot: str = HEAD,
    drive: tuple[str, float] = ("torque", 1.0),
) -> Proposal:
    """What is made of three logs, after angles and rates were changed."""
    Path("head.xml").write_text(robot)
    for seed in range(3):
        angles, turning, torques = moved(truth, seed)
        named = [("{}_deg", ("pan", "tilt"), np.degrees(place(angles))), ("gyro_{}", "xyz", turn(turning))]
        columns = {name.format(k): row for name, keys, rows in named for k, row in zip(keys, rows.T, strict=True)}
        torque = {f"{joint}_{drive[0]}": row / drive[1] for joint, row in zip(("pan", "tilt"), torques.T, strict=True)}
        write_csv(Path(f"logs/{seed}.csv"), {"time": np.arange(len(angles)) / RATE, **columns, **torque})
    return propose(read_robot("head.xml", None), survey(["logs/*.csv"], settings()), settings())


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def read_as(found: Proposal) -> dict[str, tuple[str, str, float]]:
    """By channel its columns with their sign, its unit, and its offset."""
    return {
        each.channel: ("−" * (each.sign < 0) + each.source, each.unit, round(each.offset, 3)) for each in found.outputs
    }


PAN, TILT = {"pan.position": ("pan_deg", "deg", 0.0)}, {"tilt.position": ("tilt_deg", "deg", 0.0)}
GYRO = {"sensor.gyro": ("gyro_x, gyro_y, gyro_z", "rad/s", 0.0)}


def axes(*columns: str) -> dict[str, tuple[str, str, float]]:
    return {f"sensor.gyro.{axis}": (column, "rad/s", 0.0) for axis, column in zip("xyz", columns, strict=True)}


def test_a_gyroscope_that_turns_as_the_joints_do_has_its_unit_and_raises_no_doubt() -> None:
    found = proposed(FRICTION)
    assert read_as(found) == PAN | TILT | GYRO
    assert found.doubts == ()


def test_a_robot_without_a_gyroscope_is_read_as_before_and_told_how_to_have_one_read() -> None:
    found = proposed(FRICTION, robot=DEAF)
    assert read_as(found) == PAN | TILT
    (doubt,) = found.doubts
    assert doubt.startswith("gyro_x, gyro_y, gyro_z are a gyro's by their names, and the model has none.")


@pytest.mark.parametrize(
    ("turn", "expected"),
    [
        (np.degrees, {"sensor.gyro": ("gyro_x, gyro_y, gyro_z", "deg/s", 0.0)}),
        (lambda w: w * [1, 1, -1], axes("gyro_x", "gyro_y", "−gyro_z")),
        (lambda w: w * [1, -1, -1], axes("gyro_x", "−gyro_y", "−gyro_z")),  # upside down
        (lambda w: w[:, [2, 0, 1]], {"sensor.gyro": ("gyro_y, gyro_z, gyro_x", "rad/s", 0.0)}),
        (lambda w: w + np.array([0.1, -0.1, 0.05]), GYRO),  # a bias
    ],
)
def test_unit_order_and_signs_of_a_gyroscope_are_found(
    turn: Callable[[Array], Array], expected: dict[str, tuple[str, str, float]]
) -> None:
    found = proposed(FRICTION, turn=turn)
    assert read_as(found) == PAN | TILT | expected
    mounted = [doubt for doubt in found.doubts if "sensor.gyro does not turn as the joints turn its site" in doubt]
    assert len(mounted) == (expected != GYRO and next(iter(expected.values()))[1] == "rad/s")


@pytest.mark.parametrize(
    ("truth", "robot"),
    [(FRICTION, HEAD), (BALANCED, BALANCED)],  # what is balanced weighs the same from any direction
)
def test_a_zero_is_found_where_the_gyroscope_turns_about_another_axis(truth: str, robot: str) -> None:
    found = proposed(truth, lambda q: q - [0, np.pi / 2], robot=robot)
    assert read_as(found) == PAN | {"tilt.position": ("tilt_deg", "deg", 90.0)} | GYRO
    assert any("as the gyroscope shows" in doubt for doubt in found.doubts)


def test_a_sign_is_found_although_a_cable_pulls_as_another_zero_would() -> None:
    found = proposed(CABLE, lambda q: q * [1, -1])
    assert read_as(found) == PAN | {"tilt.position": ("−tilt_deg", "deg", 0.0)} | GYRO
    assert [(each.unit, each.scale * each.sign) for each in found.commands] == [("N·m", 1.0)] * 2
    assert any("A spring at tilt that the model lacks" in doubt for doubt in found.doubts)


def test_a_current_gets_the_torque_constant_that_the_motion_shows() -> None:
    found = proposed(FRICTION, drive=("current", 0.4))
    assert [each.unit for each in found.commands] == ["N·m"] * 2
    assert [each.scale for each in found.commands] == pytest.approx([0.4] * 2, rel=0.05)


def test_a_gyroscope_that_turns_as_nothing_does_is_told() -> None:
    found = proposed(FRICTION, turn=lambda w: np.random.default_rng(0).normal(size=w.shape))
    assert read_as(found) == PAN | TILT | GYRO
    assert any("does not turn as the joints turn its site: whatever" in doubt for doubt in found.doubts)


def test_rates_are_those_of_a_panned_and_tilted_camera() -> None:
    tilt, speeds = np.linspace(-1.0, 1.0, 5), (0.7, 0.3)
    found = rates(
        mujoco.MjModel.from_xml_string(HEAD), 0, np.stack([0 * tilt, tilt], 1), np.tile(speeds, (len(tilt), 1))
    )
    expected = np.stack([speeds[0] * np.sin(tilt), 0 * tilt - speeds[1], speeds[0] * np.cos(tilt)], axis=1)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_the_zero_about_the_vertical_is_free_and_that_of_a_weight_is_not() -> None:
    model = compiled(mujoco.MjSpec.from_string(HEAD))
    assert felt_zeros(model) == [False, True]
    model.opt.gravity[:] = (1.0, 0.0, -9.81)
    assert felt_zeros(model) == [True, True]
