import mujoco

from dr_lab.physics.model import from_spec

XML = """
<mujoco>
  <worldbody>
    <body><joint/><geom size="0.1"/>
      <body name="hand"><joint name="joint_1"/><joint axis="1 0 0"/><geom size="0.1"/></body>
    </body>
  </worldbody>
  <actuator><motor joint="joint_1"/></actuator>
  <sensor><jointpos joint="joint_1"/></sensor>
</mujoco>
"""


def names(model: mujoco.MjModel) -> dict[str, list[str]]:
    counts = {"body": model.nbody, "joint": model.njnt, "actuator": model.nactuator, "sensor": model.nsensor}
    return {kind: [getattr(model, kind)(i).name for i in range(count)] for kind, count in counts.items()}


def test_unnamed_elements_get_names_that_nobody_has() -> None:
    spec = mujoco.MjSpec.from_string(XML)
    parameters = {"mass": {"target": "joint.joint_2.damping", "unit": "N·m·s/rad", "low": 0.0, "high": 1.0}}
    assert names(from_spec("hand", spec, parameters).nominal()) == {
        "body": ["world", "body_1", "hand"],
        "joint": ["joint_0", "joint_1", "joint_2"],
        "actuator": ["actuator_0"],
        "sensor": ["sensor_0"],
    }
    assert names(spec.compile())["body"] == ["world", "", "hand"]


def test_a_name_that_is_taken_is_avoided() -> None:
    spec = mujoco.MjSpec.from_string(XML.replace('name="hand"', 'name="body_1"'))
    assert names(from_spec("hand", spec, {}).nominal())["body"] == ["world", "body_1_", "body_1"]
