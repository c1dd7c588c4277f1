import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from dr_lab.diagnosis.windows.channels import Tape, available, residual, resolve
from dr_lab.errors import UnknownNameError

XML = """
<mujoco>
  <worldbody>
    <body name="arm">
      <joint name="arm"/><geom size="0.1"/><site name="imu"/>
      <body name="ball"><joint name="shoulder" type="ball"/><geom size="0.1"/></body>
    </body>
  </worldbody>
  <sensor>
    <gyro name="gyro" site="imu"/>
    <framequat name="pose" objtype="body" objname="ball"/>
  </sensor>
</mujoco>
"""


def tape(step: float, steps: int) -> Tape:
    time = step * np.arange(steps + 1.0)
    qpos = np.stack([np.power(time, 3) - time, time, time, time, time], axis=-1)[None, None]
    qvel = np.stack([3 * np.square(time) - 1, time, time, time], axis=-1)[None, None]
    return Tape(qpos, qvel, np.zeros((1, 1, steps, 7)), np.zeros((1, 1, 1)), np.zeros((1, 1, steps, 0)), step)


def test_positions_between_steps_are_exact_for_cubics() -> None:
    model = mujoco.MjModel.from_xml_string(XML)
    (channel,) = resolve(model, ["arm.position"])
    time = np.array([[[0.0, 0.003, 0.0447, 0.0999]]])
    np.testing.assert_allclose(tape(0.01, 10).read(channel, time)[0, 0, :, 0], (time**3 - time)[0, 0], atol=1e-14)


def test_channels_are_joint_states_and_sensors() -> None:
    model = mujoco.MjModel.from_xml_string(XML)
    axes = {f"sensor.gyro.{axis}" for axis in "xyz"}
    assert set(available(model)) == {"arm.position", "arm.velocity", "sensor.gyro", "sensor.pose", *axes}
    with pytest.raises(UnknownNameError, match=r"Did you mean 'arm\.position'"):
        resolve(model, ["arm.positon"])


def test_orientations_are_compared_on_so3() -> None:
    model = mujoco.MjModel.from_xml_string(XML)
    (channel,) = resolve(model, ["sensor.pose"])
    rotation = Rotation.from_rotvec([0.3, -0.2, 0.1])
    turn = Rotation.from_rotvec([0.0, 0.04, 0.0])
    simulated = rotation.as_quat(scalar_first=True).reshape(1, 1, 1, 4)
    measured = -(rotation * turn).as_quat(scalar_first=True).reshape(1, 1, 4)  # q and −q are one orientation
    np.testing.assert_allclose(residual(channel, simulated, measured)[0, 0, 0], [0.0, 0.04, 0.0], atol=1e-12)
