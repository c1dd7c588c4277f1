import mujoco
import numpy as np
import pytest
from effect_machines import placed

from dr_lab.physics.model import Declared, from_spec
from dr_lab.physics.simulator import Simulator
from dr_lab.physics.straight import Straight

ROBOT = """<robot name="arm">
  <link name="base"/>
  <link name="arm"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="tool"><inertial><origin xyz="0 0 0"/><mass value="0.5"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint>
  <joint name="mount" type="fixed"><parent link="arm"/><child link="tool"/><origin xyz="0 0 -1"/></joint>
</robot>"""
FREE = """<mujoco><compiler fusestatic="true"/><worldbody><body name="frame"><freejoint/>
  <geom type="box" size="0.1 0.2 0.3"/><body name="antenna" pos="0 0 1"><geom size="0.05"/></body>
</body></worldbody></mujoco>"""


def swinging(model: mujoco.MjModel) -> np.ndarray:
    data = mujoco.MjData(model)
    data.qpos[0] = 0.4
    mujoco.mj_step(model, data, 200)
    return data.qpos.copy()


@pytest.mark.parametrize("parameters", [{}, "inertial", {"inertial": ["arm"]}])
def test_the_inertia_of_a_welded_link_counts_once(parameters: Declared) -> None:
    """MuJoCo fuses the links of a URDF: its arm has the tool's inertia, which the tool brings as well."""
    spec = mujoco.MjSpec.from_string(ROBOT)
    model = from_spec("arm", spec, parameters).nominal()
    assert model.body("arm").subtreemass[0] == pytest.approx(1.5)
    np.testing.assert_allclose(swinging(model), swinging(spec.compile()), rtol=1e-9)


def test_bodies_that_the_file_lets_fuse_keep_their_names() -> None:
    spec = mujoco.MjSpec.from_string(FREE)
    varied = {"mass": {"target": "body.antenna.mass", "unit": "kg", "low": 0.1, "high": 1.0}}
    model = from_spec("frame", spec, varied)
    assert model.nominal().body("frame").subtreemass[0] == pytest.approx(spec.compile().body("frame").mass[0])
    loaded = model.with_effect(placed(model, "rigid_payload", "frame"))
    assert not Straight.of(loaded).plain


def test_a_model_whose_bodies_may_sleep_is_simulated() -> None:
    sleepy = FREE.replace("<worldbody>", '<option><flag sleep="enable"/></option><worldbody>')
    simulator = Simulator(from_spec("frame", mujoco.MjSpec.from_string(sleepy), {}), 2)
    simulator.step(np.zeros((2, 0)), 10)
    assert (simulator.batch.bind("qvel")[:, 2] < 0.0).all()


def test_a_muscle_keeps_its_strength() -> None:
    """MuJoCo would make it of the inertia that it carries."""
    spec = mujoco.MjSpec.from_string("""<mujoco><worldbody><body name="arm"><joint name="elbow" axis="0 1 0"/>
      <inertial pos="0 0 -0.3" mass="1" diaginertia="0.01 0.01 0.01"/></body></worldbody>
      <actuator><muscle name="biceps" joint="elbow" lengthrange="-1 1"/></actuator></mujoco>""")
    varied = {"mass": {"target": "body.arm.mass", "unit": "kg", "low": 0.5, "high": 8.0}}
    model = from_spec("arm", spec, varied)
    forces = [pulling(each) for each in (spec.compile(), model.nominal(), model.compile(np.array([4.0])))]
    np.testing.assert_allclose(forces, forces[0])
    assert abs(forces[0]) > 1.0


def pulling(model: mujoco.MjModel) -> float:
    data = mujoco.MjData(model)
    data.qpos[0], data.act[0] = 0.3, 1.0
    mujoco.mj_forward(model, data)
    return float(data.actuator_force[0])
