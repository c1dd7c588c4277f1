import re
from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from diagnosis_machines import (
    localise_settings,
    log_of,
    model_of,
    pendulum,
    predicted_settings,
    simulated,
    solver_settings,
    steps_command,
    swinging,
    windows_of,
)

from dr_lab.diagnosis.fit.states import fit_states
from dr_lab.diagnosis.localise import Region, localise
from dr_lab.physics.model import Model
from dr_lab.trajectory import Log

BLIND = """<mujoco model="blind"><option gravity="0 0 0"/>
  <worldbody><body name="rod"><joint name="hinge" axis="0 1 0"/>
  <geom size="0.1"/><site name="imu"/></body></worldbody>
  <sensor><gyro name="gyro" site="imu"/></sensor></mujoco>"""


def regions(model: Model, logs: list[Log]) -> list[Region]:
    settings = localise_settings()
    cutting = predicted_settings(length=settings.length, seconds=settings.seconds)
    windows = windows_of(model, logs, cutting)
    return localise(*fit_states(model, model.space.nominal, windows, solver_settings(), 1), settings)


def limit(words: str, feature: str, side: str) -> float:
    found = re.search(rf"{re.escape(feature)} {side} ([-0-9.e]+)", words)
    assert found is not None, words
    return float(found[1])


def logs_with(size: float, where: Callable[[mujoco.MjData], bool]) -> list[Log]:
    def push(data: mujoco.MjData) -> None:
        data.qfrc_applied[0] = size if where(data) else 0.0

    return [swinging(f"log_{k}", pendulum().nominal(), k, force=push, seconds=6.0) for k in range(2)]


def test_an_error_at_low_speed_is_found_there() -> None:
    worst = regions(pendulum(), logs_with(0.1, lambda data: bool(abs(data.qvel[0]) < 1.0)))[0]
    assert worst.signal == "hinge.position"
    assert 0.8 < limit(worst.region, "|hinge velocity|", "<") < 1.4
    assert "rad/s" in worst.region
    assert worst.share > 2.5 * worst.samples
    assert worst.chi2 > 10


def test_an_error_at_high_speed_is_found_there() -> None:
    worst = regions(pendulum(), logs_with(-0.1, lambda data: bool(abs(data.qvel[0]) > 2.0)))[0]
    assert 1.5 < limit(worst.region, "|hinge velocity|", ">") < 4.0
    assert worst.share > 1.5 * worst.samples


@pytest.mark.parametrize("size", [pytest.param(1.0, marks=pytest.mark.slow), 0.1])
def test_an_error_on_one_side_is_found_there(size: float) -> None:
    worst = regions(pendulum(), logs_with(size, lambda data: bool(data.qpos[0] > 0.4)))[0]
    assert 0.35 < limit(worst.region, "hinge position", ">") < 0.65
    assert "reversed" not in worst.region  # late samples, which err most, are no place of the motion
    assert worst.share > 0.6


def test_a_position_that_is_not_measured_is_no_place() -> None:
    """The simulated one is as wrong as it began."""

    def push(data: mujoco.MjData) -> None:
        data.qfrc_applied[0] = 0.1 * float(data.qpos[0] > 0.4)

    command, rng = steps_command("drive", 1.0, 6.0, 0), np.random.default_rng(0)
    motion = simulated(pendulum().nominal(), command, 6.0, qpos=[0.8], force=push)
    read = {"hinge.position": motion["qpos"][:, 0], "hinge.velocity": motion["qvel"][:, 0]}
    log = log_of("a", {k: (motion["time"], v + 1e-3 * rng.normal(size=len(v))) for k, v in read.items()}, command)
    both = regions(pendulum(), [log])
    assert any("hinge position" in region.region for region in both if region.signal == "hinge.velocity")
    alone = regions(pendulum(), [replace(log, outputs={"hinge.velocity": log.outputs["hinge.velocity"]})])
    assert len(alone) > 0
    assert not any("hinge position" in region.region for region in alone)


def test_a_right_model_fails_nowhere_in_particular() -> None:
    model = pendulum()
    found = regions(model, [swinging("a", model.nominal(), 0, seconds=6.0)])
    assert all(region.chi2 < 2 for region in found)


def test_logs_without_joints_and_commands_have_no_regions() -> None:
    model = model_of(BLIND)
    motion = simulated(model.nominal(), None, 3.0)
    noisy = motion["sensordata"] + 1e-3 * np.random.default_rng(0).normal(size=(len(motion["time"]), 3))
    assert regions(model, [log_of("a", {"sensor.gyro": (motion["time"], noisy)})]) == []


def test_a_band_of_one_feature_is_one_condition() -> None:
    """A force that acts between two places alone: both bounds stand around the feature."""
    (region,) = regions(pendulum(), logs_with(0.1, lambda data: bool(abs(data.qpos[0]) < 0.4)))
    number = "(-?[0-9.]+)"
    found = re.fullmatch(rf"{number} rad < hinge position < {number} rad", region.region)
    assert found is not None, region.region
    assert [float(text) for text in found.groups()] == pytest.approx([-0.4, 0.4], abs=0.05)
