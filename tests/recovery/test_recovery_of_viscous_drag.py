"""The drag of a body that floats is found by the exact solution of its motion, at three magnitudes."""

import json
from pathlib import Path

import numpy as np
import pytest

from dr_lab.__main__ import main

MASS = 8.5  # kg; the model has 8
MJCF = """<mujoco model="rov">
  <option timestep="0.005" integrator="RK4" gravity="0 0 0"/>
  <worldbody><body name="rov"><joint name="float" type="free"/>
    <inertial mass="8" pos="0 0 0" diaginertia="0.2 0.2 0.2"/></body></worldbody>
  <actuator>
    <motor name="surge" joint="float" gear="1 0 0 0 0 0"/>
    <motor name="sway" joint="float" gear="0 1 0 0 0 0"/>
    <motor name="heave" joint="float" gear="0 0 1 0 0 0"/>
  </actuator>
</mujoco>"""
STEP, HELD, COUNT = 0.01, 50, 1000  # s, samples of a command, samples


def write_log(path: Path, drag: float, rng: np.random.Generator) -> None:
    """m v' = u − c v under held forces: v goes to u/c with the time constant m/c."""
    force = np.repeat(rng.uniform(-10.0, 10.0, (COUNT // HELD, 3)), HELD, axis=0)
    left = np.exp(-drag * STEP / MASS)
    place, speed = np.zeros((COUNT, 3)), np.zeros(3)
    for k, u in enumerate(force[:-1]):
        final = u / drag
        place[k + 1] = place[k] + final * STEP + (speed - final) * (1.0 - left) * MASS / drag
        speed = final + (speed - final) * left
    turn = np.array([1.0, 0.0, 0.0, 0.0]) + rng.normal(scale=5e-4, size=(COUNT, 4))
    turn /= np.linalg.norm(turn, axis=1, keepdims=True)
    seen = place + rng.normal(scale=1e-3, size=place.shape)
    rows = np.column_stack([STEP * np.arange(COUNT), seen, turn, force])
    np.savetxt(path, rows, "%.9g", ",", header="t,x,y,z,qw,qx,qy,qz,surge,sway,heave", comments="")


@pytest.mark.slow
@pytest.mark.parametrize("drag", [2.0, 5.0, 12.0])
def test_it_is_named(drag: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("rov.xml").write_text(MJCF, encoding="utf-8")
    rng = np.random.default_rng(round(drag))
    for k in range(5):
        write_log(tmp_path / f"dive_{k}.csv", drag, rng)
    assert main(["init", "rov.xml", *map(str, sorted(tmp_path.glob("*.csv")))]) == 0
    close = ["close", "--config-dir", "mine", "model=rov", "measurements=rov", "threads=1", "hydra.run.dir=run"]
    assert main([*close, "windows.seconds=15"]) == 0
    report = json.loads(Path("run/report.json").read_text(encoding="utf-8"))
    last = report["ladder"][-1]
    assert (report["verdict"], last["effects"]) == ("named", ["viscous_drag@rov"])
    found = last["parameters"]["viscous_drag@rov.translation"]
    assert found["std"] < 0.06 * drag
    assert abs(found["value"] - drag) < 3 * found["std"]
