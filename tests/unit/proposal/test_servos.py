"""`dr-lab init` on machines that a servo moves, and whose model has none."""

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml
from own_robot import URDF, servo_log, write_csv

from dr_lab.__main__ import main
from dr_lab.trajectory import Array

# An arm that lies level at zero, as light as hobby servos carry it.
ARM = """<mujoco model="arm"><compiler angle="radian"/><option timestep="0.002" integrator="RK4"/><worldbody><body>
  <joint name="turn" axis="0 -1 0"/><geom type="capsule" fromto="0 0 0 0.12 0 0" size="0.008" mass="0.1"/>
</body></worldbody></mujoco>"""
SAMPLE = 0.02  # s
FASTEST, GAIN = 4.6, 20.0  # rad/s and 1/s, of a hobby servo: it turns as fast as it can until it is nearly there


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def geared(seed: int) -> tuple[Array, Array, Array]:
    """Time, target and angle of a servo whose gears let nothing of the arm's weight through."""
    rng = np.random.default_rng(seed)
    target = np.repeat(rng.uniform(-1.8, 1.8, 6), 25)
    angle = np.zeros(len(target))
    for k in range(1, len(angle)):
        angle[k] = angle[k - 1] + SAMPLE * np.clip(GAIN * (target[k - 1] - angle[k - 1]), -FASTEST, FASTEST)
    return (
        np.asarray(SAMPLE * np.arange(len(target)), np.float64),
        target,
        angle + rng.normal(scale=1e-3, size=len(angle)),
    )


def proposed(robot: str, logs: list[dict[str, Array]]) -> dict[str, Any]:
    """The written measurements."""
    paths = [str(write_csv(Path(f"logs/log_{k}.csv"), log)) for k, log in enumerate(logs)]
    assert main(["init", robot, *paths, "name=it"]) == 0
    return yaml.safe_load(Path("mine/measurements/it.yaml").read_text(encoding="utf-8"))


def test_an_offset_that_the_weight_does_not_show_is_not_added(capsys: pytest.CaptureFixture[str]) -> None:
    """A servo whose stiffness just holds an arm upright would explain such motion, but any arm's as well."""
    Path("arm.xml").write_text(ARM)
    names = ("time", "target_rad", "angle_rad")
    found = proposed("arm.xml", [dict(zip(names, geared(seed), strict=True)) for seed in range(3)])
    assert found["outputs"] == {"turn.position": {"column": "angle_rad", "unit": "rad"}}
    assert found["commands"] == {"turn": {"column": "target_rad", "unit": "rad"}}
    told = capsys.readouterr().out
    assert "are a guess, as the motion hardly shows them. Write its own into the model" in told
    assert "free actuator.turn.kp and .kv" in told
    assert mujoco.MjModel.from_xml_path("mine/model/it.xml").actuator_biasprm[0, 1] < 0, "a servo, no motor"


def test_targets_without_a_unit_are_read_in_that_of_the_angle() -> None:
    """Numbers within ±1 of a full stroke; by themselves they may be anything."""
    Path("arm.xml").write_text(ARM)
    logs = [(time, target / np.pi, angle / np.pi) for time, target, angle in map(geared, range(3))]
    found = proposed("arm.xml", [dict(zip(("t", "action", "sensor"), log, strict=True)) for log in logs])
    angle, target = found["outputs"]["turn.position"], found["commands"]["turn"]
    assert (angle.pop("column"), target.pop("column")) == ("sensor", "action")
    assert angle == target
    assert "offset" not in angle


def test_an_offset_of_an_angle_goes_to_the_targets_of_its_servo() -> None:
    """Both count from upright; the robot of the URDF hangs at zero."""
    Path("two.urdf").write_text(URDF)

    def upright(seed: int) -> dict[str, Array]:
        log = {f"{name}_rad" if name != "time" else name: values for name, values in servo_log(seed).items()}
        return log | {name: log[name] + np.pi for name in ("shoulder_pos_rad", "shoulder_target_rad")}

    found = proposed("two.urdf", [upright(seed) for seed in range(2)])
    angle, target = found["outputs"]["shoulder.position"], found["commands"]["shoulder"]
    assert abs(angle["offset"]) == pytest.approx(np.pi)
    assert target["offset"] == angle["offset"]
    assert "offset" not in found["commands"]["elbow"]
    kp = mujoco.MjModel.from_xml_path("mine/model/it.xml").actuator_gainprm[:, 0]
    np.testing.assert_allclose(kp, [40.0, 15.0], rtol=0.1)  # N·m/rad, of the machine


SERVO = """<mujoco model="servo"><compiler angle="radian"/><option timestep="0.002" integrator="RK4"/><worldbody>
  <body name="disc"><joint name="hub" axis="0 0 1" armature="0.02" damping="0.05"/>
  <geom type="cylinder" size="0.01 0.005" mass="0.01" contype="0" conaffinity="0"/></body></worldbody>
  <actuator><position name="hub_servo" joint="hub" kp="30" kv="1"/></actuator></mujoco>"""


def test_the_pull_of_a_stiff_servo_widens_no_bound_of_damping() -> None:
    """What holds 1 rad by 30 N·m/rad brakes nothing; 0.2 N·m·s/rad stop 0.02 kg·m² in a tenth of a second."""
    Path("servo.xml").write_text(SERVO)
    model, logs = mujoco.MjModel.from_xml_string(SERVO), []
    for seed in range(3):
        data, rng, rows = mujoco.MjData(model), np.random.default_rng(seed), []
        levels = rng.uniform(-1.0, 1.0, 20)
        for k in range(3000):
            data.ctrl[:] = levels[k // 150]
            if k % 5 == 0:
                rows.append((data.time, data.ctrl[0], data.qpos[0] + rng.normal(scale=1e-4)))
            mujoco.mj_step(model, data)
        logs.append(dict(zip(("time", "hub_target_rad", "hub_rad"), np.array(rows).T, strict=True)))
    proposed("servo.xml", logs)
    (entry,) = yaml.safe_load(Path("mine/model/it.yaml").read_text(encoding="utf-8"))["parameters"].values()
    assert entry["target"] == "joint.hub.damping"
    assert 0.2 <= entry["high"] < 1.0
