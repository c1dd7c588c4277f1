"""A fit's linear model says where the other parameters make up for some that are moved."""

import numpy as np
import pytest

from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from tests.diagnosis_machines import log_of, model_of, simulated, solver_settings, steps_command, windows_of

# Two bodies on one slide, of which the logs tell the sum alone: 2 kg and 1 kg.
SLED = """<mujoco model="sled">
  <option timestep="0.002" integrator="RK4" gravity="0 0 0"/>
  <worldbody><body name="sled"><joint name="rail" type="slide" axis="1 0 0" damping="0.4"/>
    <inertial mass="2" pos="0 0 0" diaginertia="1 1 1"/>
    <body name="box"><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/></body>
  </body></worldbody>
  <actuator><motor name="drive" joint="rail"/></actuator>
</mujoco>"""
FREE = {
    "sled.mass": {"target": "body.sled.mass", "unit": "kg", "low": 0.5, "high": 2.6},
    "box.mass": {"target": "body.box.mass", "unit": "kg", "low": 0.1, "high": 5.0},
}


@pytest.mark.parametrize(("box", "sled"), [(1.2, 1.8), (0.7, 2.3), (0.2, 2.6)])
def test_one_mass_takes_over_from_the_other_as_far_as_its_bound(box: float, sled: float) -> None:
    model, command = model_of(SLED, FREE), steps_command("drive", 4.0, 2.0, 3)
    motion = simulated(model.nominal(), command, 2.0)
    reading = motion["qpos"][:, 0] + 1e-4 * np.random.default_rng(5).normal(size=len(motion["time"]))
    windows = windows_of(model, [log_of("log", {"rail.position": (motion["time"], reading)}, command)], noise=1e-4)
    fitter = Fitter(Replay(model, windows, 1), solver_settings())
    fit = fitter.run(np.array([2.0, 1.0]))
    z, delta = fit.made_up(fitter.space, {"box.mass": box})
    assert z[1] == pytest.approx(box)
    assert z[0] == pytest.approx(min(sled + fit.z.sum() - 3.0, 2.6), abs=0.02)
    there = fitter.begin(z, delta)
    if sled < 2.6:
        assert there.cost - fit.cost < 1.0
        assert fitter.begin(np.array([fit.z[0], box]), fit.delta).cost - fit.cost > 100.0
