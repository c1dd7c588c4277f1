import mujoco
import numpy as np
import pytest

from dr_lab.plants.hidden.cable_force import CableForce
from dr_lab.plants.mujoco_machine import MujocoMachine

LENGTH, STIFFNESS, WAY = 0.4, 100.0, np.array([0.6, 0.8])  # m, N/m, direction in x and z
SLIDER = """<mujoco><option gravity="0 0 0"/><worldbody><body name="slider">
  <joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" axis="0 0 1"/>
  <inertial pos="0.1 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody></mujoco>"""


@pytest.mark.parametrize("stretch", [-0.1, 0.0, 0.5])
def test_it_pulls_by_its_stretch_and_is_slack_below(stretch: float) -> None:
    plain, place = MujocoMachine.of(mujoco.MjModel.from_xml_string(SLIDER)), [0.2, -0.3]
    x, z = np.array(place) + [0.1, 0.0] + (LENGTH + stretch) * WAY
    cabled = CableForce("slider", [x, 0.0, z], LENGTH, STIFFNESS).alter(plain)
    _, force = cabled.terms(place, [0.0, 0.0], [], [0.0, 0.0])
    np.testing.assert_allclose(force, STIFFNESS * max(stretch, 0.0) * WAY, atol=1e-9)
