"""Velocity servos begin where their joints stand, each simulation at its own."""

import mujoco
import numpy as np
from mujoco.batch import Batch

from dr_lab.physics.setpoints import Setpoints

XML = """<mujoco><option gravity="0 0 0"/><worldbody>
  <body><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/><joint name="free" axis="0 1 0"/>
    <body><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/><joint name="driven" axis="0 1 0"/></body>
  </body>
</worldbody><actuator>
  <motor name="motor" joint="free"/>
  <general name="lag" joint="free" dyntype="filter" dynprm="0.1"/>
  <intvelocity name="servo" joint="driven" kp="50" kv="5" gear="2" actrange="-9 9"/>
</actuator></mujoco>"""


def test_a_servo_at_rest_stays_wherever_its_joint_is() -> None:
    batch = Batch(mujoco.MjModel.from_xml_string(XML), 3, 1)
    setpoints, qpos = Setpoints(batch), batch.bind("qpos")
    qpos[:] = [[0.1, 0.5], [0.2, -1.0], [0.3, 2.0]]
    setpoints.follow(np.array([0, 1]))
    np.testing.assert_array_equal(batch.bind("act"), [[0.0, 1.0], [0.0, -2.0], [0.0, 0.0]])
    batch.step(nstep=20)
    np.testing.assert_allclose(batch.bind("qpos")[:2], [[0.1, 0.5], [0.2, -1.0]], atol=1e-12)
    assert abs(batch.bind("qpos")[2, 1] - 2.0) > 0.1
