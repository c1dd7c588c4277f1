"""The friction loss of a machine that MuJoCo itself simulates, with another step, is found at three magnitudes."""

import json
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from dr_lab.__main__ import main

MJCF = """<mujoco model="swing">
  <option timestep="0.002" integrator="RK4"/>
  <worldbody><body name="link">
    <inertial mass="0.8" pos="0 0 -0.2" diaginertia="0.01 0.01 0.001"/>
    <joint name="hinge" axis="0 1 0" damping="0.02"/>
  </body></worldbody>
  <actuator><motor name="hinge" joint="hinge"/></actuator>
</mujoco>"""
STEP, SAMPLE, HELD, SECONDS, PEAK = 5e-4, 0.005, 0.2, 8.0, 1.5  # s, s, s, s, N·m


def write_log(path: Path, friction: float, rng: np.random.Generator) -> None:
    """Encoders of 0.5 mrad beside a link that is 10 % heavier than the model's."""
    spec = mujoco.MjSpec.from_string(MJCF)
    spec.option.timestep = STEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.joint("hinge").frictionloss = friction
    spec.body("link").mass *= 1.1
    spec.body("link").inertia = 1.1 * np.asarray(spec.body("link").inertia)
    model = spec.compile()
    data, rows = mujoco.MjData(model), []
    levels = rng.uniform(-PEAK, PEAK, round(SECONDS / HELD))
    for k in range(round(SECONDS / STEP)):
        data.ctrl[:] = levels[int(k * STEP / HELD + 1e-9)]
        if k % round(SAMPLE / STEP) == 0:
            rows.append((data.time, data.qpos[0] + rng.normal(scale=5e-4), data.ctrl[0]))
        mujoco.mj_step(model, data)
    np.savetxt(path, np.array(rows), "%.9g", ",", header="time,hinge_pos,hinge_torque", comments="")


def ladder_of(friction: float) -> tuple[str, dict[str, Any]]:
    """The verdict on such a machine, and the last rung of its ladder."""
    Path("swing.xml").write_text(MJCF, encoding="utf-8")
    rng = np.random.default_rng(round(100 * friction))
    for k in range(4):
        write_log(Path(f"log_{k}.csv"), friction, rng)
    assert main(["init", "swing.xml", *map(str, sorted(Path().glob("*.csv")))]) == 0
    close = ["close", "--config-dir", "mine", "model=swing", "measurements=swing", "threads=1", "hydra.run.dir=run"]
    assert main([*close, "windows.seconds=15"]) == 0
    report = json.loads(Path("run/report.json").read_text(encoding="utf-8"))
    return report["verdict"], report["ladder"][-1]


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.15, 0.25, 0.4])
def test_it_is_named(friction: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    verdict, last = ladder_of(friction)
    assert (verdict, last["effects"]) == ("named", ["soft_friction@hinge"])
    torque, softness = (last["parameters"][f"soft_friction@hinge.{name}"] for name in ("torque", "softness"))
    assert torque["value"] == pytest.approx(friction, rel=0.02)
    assert softness["value"] == pytest.approx(1.0, abs=0.2)
    assert last["held_out"]["chi2"] < 1.3  # the machine's step, which the model has not, moves it by half a noise


@pytest.mark.slow
def test_where_the_noise_hides_the_creep_it_is_coulomb_friction(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At 0.05 N·m the link creeps at 1.2 mrad/s at most, 0.4 mrad in a window."""
    monkeypatch.chdir(tmp_path)
    verdict, last = ladder_of(0.05)
    assert (verdict, last["effects"]) == ("named", ["coulomb_friction@hinge"])
    assert last["parameters"]["coulomb_friction@hinge.torque"]["value"] == pytest.approx(0.05, rel=0.02)
