"""What recordings show of learned forces."""

import mujoco
import numpy as np

from dr_lab.comparison.overlays import seen_in_the_middle
from dr_lab.diagnosis.missing_force.residual_force import ResidualForce

XML = """<mujoco><compiler angle="radian"/><worldbody>
  <body pos="0 0 1"><freejoint name="base"/><geom size="0.1"/>
    <body><joint name="arm" axis="0 1 0"/><geom size="0.1" pos="0.3 0 0"/>
      <body pos="0.3 0 0"><joint name="wrist" axis="0 1 0" ref="0.4"/><geom size="0.1" pos="0.2 0 0"/></body>
    </body></body>
  </worldbody></mujoco>"""


def test_joints_that_no_log_shows_rest_where_the_model_has_them() -> None:
    model = mujoco.MjModel.from_xml_string(XML)
    position, velocity, none = np.array([0.1, -0.2]), np.array([1.0, 2.0]), np.zeros(2)
    seen = seen_in_the_middle(model, {"arm": ResidualForce(position, velocity, none, none)}, np.zeros((2, 0)))
    np.testing.assert_array_equal(seen.qpos[:, model.joint("arm").qposadr[0]], position)
    np.testing.assert_array_equal(seen.qvel[:, model.joint("arm").dofadr[0]], velocity)
    np.testing.assert_array_equal(seen.qpos[:, model.joint("wrist").qposadr[0]], 0.4)
    np.testing.assert_array_equal(seen.qpos[:, :7], np.tile([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0], (2, 1)))


def test_states_of_windows_that_diverge_are_none() -> None:
    model = mujoco.MjModel.from_xml_string(XML)
    position, velocity, noise = np.array([0.1, 3e6]), np.array([1.0, 1e7]), np.zeros(2)
    forces = {"arm": ResidualForce(position, velocity, np.array([0.5, np.nan]), noise)}
    seen = seen_in_the_middle(model, forces, np.zeros((2, 0)))
    arm = model.joint("arm")
    np.testing.assert_array_equal(seen.qpos[:, arm.qposadr[0]], [0.1, np.nan])
    np.testing.assert_array_equal(seen.qvel[:, arm.dofadr[0]], [1.0, np.nan])
