import mujoco
import numpy as np
import pytest
from effect_machines import placed

from dr_lab.errors import ModelError
from dr_lab.physics.compiling import written
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


ALIGNED = """<mujoco><compiler {compiler}/><worldbody><body name="box" pos="0 0 1"><freejoint {joint}/>
  <inertial mass="1" pos="{centre} 0 0" diaginertia="0.01 0.02 0.03"/><geom size="0.1"/></body></worldbody></mujoco>"""
CENTRE: Declared = {"centre": {"target": "body.box.ipos[0]", "unit": "m", "low": -0.2, "high": 0.3}}


@pytest.mark.parametrize(("compiler", "joint"), [('alignfree="true"', ""), ("", 'align="true"')])
def test_a_free_frame_that_a_compiler_moves_is_refused_and_where_it_is_does_not_move(compiler: str, joint: str) -> None:
    text = ALIGNED.format(compiler=compiler, joint=joint, centre=0.1)
    with pytest.raises(ModelError, match=r"moves the frame of box into its centre of mass \(compiler alignfree"):
        from_spec("box", mujoco.MjSpec.from_string(text), CENTRE)
    spec = mujoco.MjSpec.from_string(text.replace("<compiler", '<compiler savecompiled="true"'))
    from_spec("box", mujoco.MjSpec.from_string(written(spec)), CENTRE)  # the remedy
    model = from_spec("box", mujoco.MjSpec.from_string(text.replace("0.1 0 0", "0 0 0")), CENTRE)
    moved = model.compile(np.array([0.2]))
    np.testing.assert_array_equal(moved.qpos0, model.nominal().qpos0)
    np.testing.assert_array_equal(moved.body_ipos[1], [0.2, 0.0, 0.0])
