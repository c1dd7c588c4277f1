"""Delayed and slow sensors of a replay read what they would have read without a cut."""

import mujoco
import numpy as np
import pytest

from dr_lab.physics.law import History
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import Simulator

STEP, CUT, AFTER = 0.002, 200, 60
XML = """<mujoco model="late"><option timestep="0.002" integrator="RK4"/>
  <worldbody>
    <body><joint name="hinge" axis="0 1 0" damping="0.05"/>
      <inertial mass="0.5" pos="0 0 -0.3" diaginertia="0.005 0.005 0.001"/></body>
    {more}
  </worldbody>
  <actuator><motor joint="hinge" delay="0.01" nsample="6"/></actuator>
  <sensor>
    <jointpos joint="hinge" delay="0.05" nsample="25"/><jointvel joint="hinge" delay="0.03" nsample="40"/>
    <jointpos joint="hinge" interval="0.01" nsample="3"/><jointactuatorfrc joint="hinge" delay="0.02" nsample="10"/>
  </sensor></mujoco>"""
TOP = """<body pos="1 0 0"><freejoint/><geom type="box" size="0.1 0.2 0.3"/></body>"""


@pytest.mark.parametrize("more", ["", TOP])
def test_a_cut_motion_goes_on_as_if_it_was_not_cut(more: str) -> None:
    spec = mujoco.MjSpec.from_string(XML.format(more=more))
    model, compiled = Model("late", spec, (), {}), spec.compile()
    data, controls = mujoco.MjData(compiled), np.sin(0.05 * np.arange(CUT + AFTER))[:, None]
    data.qpos[0], data.qvel[:] = 1.0, np.linspace(0.5, 1.0, compiled.nv)
    qpos, qvel, sensors = [], [], []
    for control in controls:
        qpos.append(data.qpos.copy())
        qvel.append(data.qvel.copy())
        data.ctrl[:] = control
        mujoco.mj_step(compiled, data)
        sensors.append(data.sensordata.copy())
    speed = np.array(qvel)
    middle = ((speed[1:] + speed[:-1]) / 2)[None, CUT - 100 : CUT]
    past = controls[None, CUT - 100 : CUT]
    history = History(np.zeros(1), np.zeros((1, 100, compiled.nq)), middle, past)
    start = qpos[CUT][None, None], qvel[CUT][None, None]
    rollout = Simulator(model, 1).replay(np.empty((1, 0)), *start, controls[None, CUT:], past, history)
    np.testing.assert_allclose(rollout.sensordata[0], np.array(sensors[CUT:]), atol=1e-3)
    assert not rollout.infeasible.any()


def test_sensors_of_a_motion_without_past_have_read_its_start() -> None:
    model = Model("late", mujoco.MjSpec.from_string(XML.format(more="")), (), {})
    start, rest, controls = np.full((1, 1, 1), 0.7), np.zeros((1, 1, 1)), np.zeros((1, 5, 1))
    rollout = Simulator(model, 1).replay(np.empty((1, 0)), start, rest, controls, controls)
    np.testing.assert_allclose(rollout.sensordata[0, :, 0], 0.7)
