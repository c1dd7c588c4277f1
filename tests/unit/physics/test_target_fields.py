"""What a target writes into a spec, into a batch's fields and by recompiling is one and the same."""

import mujoco
import numpy as np
import pytest

from dr_lab.errors import ModelError
from dr_lab.physics.model import from_spec
from dr_lab.physics.simulator import Simulator
from dr_lab.physics.target import Target

XML = """
<mujoco model="toy">
  <compiler angle="radian"/>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 0.1" solref="0.03 1"/>
    <body name="base" pos="0 0 1" quat="0.9 0.1 -0.3 0.2">
      <freejoint name="free"/>
      <inertial mass="3" pos="0.02 0 0" diaginertia="0.3 0.2 0.25"/>
      <body name="arm" pos="0.1 0.2 0.3" quat="0.8 0.4 0.2 -0.4">
        <inertial mass="2" pos="0 0 -0.4" quat="0.6 0 0.8 0" diaginertia="0.3 0.2 0.15"/>
        <joint name="hinge" axis="0.1 1 0.2" ref="0.3" range="-1 1" limited="true" damping="0.5" frictionloss="0.2"/>
        <geom name="foot" size="0.05" pos="0 0 -0.6" mass="0" solimp="0.8 0.9 0.01 0.4 2"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="servo" joint="hinge" kp="30" kv="2" timeconst="0.05" forcerange="-4 6"/>
    <motor name="motor" joint="hinge"/>
  </actuator>
</mujoco>
"""
NOMINAL = {
    "joint.hinge.ref": 0.3,
    "joint.hinge.turn[0]": 0.0,
    "joint.hinge.turn[2]": 0.0,
    "joint.hinge.solref_limit[0]": 0.02,
    "joint.hinge.solimp_limit[1]": 0.95,
    "joint.hinge.solref_friction[0]": 0.02,
    "joint.hinge.solimp_friction[0]": 0.9,
    "joint.free.armature": 0.0,
    "body.arm.turn[0]": 0.0,
    "body.arm.turn[1]": 0.0,
    "body.arm.turn[2]": 0.0,
    "geom.floor.solref[0]": 0.03,
    "geom.foot.solimp[2]": 0.01,
    "actuator.servo.time_constant": 0.05,
    "actuator.servo.dynprm[0]": 0.05,
    "actuator.servo.forcerange[0]": -4.0,
    "actuator.servo.forcerange[1]": 6.0,
    "actuator.servo.biasprm[2]": -2.0,
}
TURNS = tuple(f"{place}.turn[{k}]" for place in ("body.arm", "joint.hinge") for k in (2, 0, 1))


def spec() -> mujoco.MjSpec:
    return mujoco.MjSpec.from_string(XML)


def moved(text: str) -> float:
    return NOMINAL[text] + (0.04 if NOMINAL[text] <= 0 or "turn" in text else 0.2 * NOMINAL[text])


def differing(a: mujoco.MjModel, b: mujoco.MjModel) -> float:
    """Largest difference of any field that a simulation reads."""
    names = ("body_quat", "jnt_axis", "qpos0", "qpos_spring", "jnt_solref", "jnt_solimp", "dof_solref", "dof_solimp")
    more = ("dof_armature", "geom_solref", "geom_solimp", "actuator_dynprm", "actuator_forcerange", "actuator_biasprm")
    derived = ("dof_M0", "dof_invweight0", "body_invweight0", "actuator_acc0")
    return max(float(np.abs(getattr(a, name) - getattr(b, name)).max()) for name in (*names, *more, *derived))


@pytest.mark.parametrize("text", NOMINAL)
def test_spec_field_and_recompiled_model_agree(text: str) -> None:
    target, one, value = Target.parse(text), spec(), moved(text)
    assert target.read(one) == pytest.approx(NOMINAL[text])
    free = from_spec(
        "toy",
        one,
        {"it": {"target": text, "unit": "1", "low": min(NOMINAL[text], value), "high": max(NOMINAL[text], value)}},
    )
    simulator = Simulator(free, 2)
    simulator.set_contexts(np.array([[value]]), np.array([1]))
    recompiled = free.compile(np.array([value]))
    assert differing(simulator.batch.get_model(1), recompiled) < 1e-12
    assert differing(simulator.batch.get_model(0), free.nominal()) < 1e-12
    assert differing(recompiled, free.nominal()) > 1e-3


def test_turns_act_one_after_the_other_and_never_accumulate() -> None:
    parameters = {text: {"target": text, "unit": "rad", "low": -0.5, "high": 0.5} for text in TURNS}
    free, z = from_spec("toy", spec(), parameters), np.array([[0.3, -0.2, 0.4, 0.1, 0.2, -0.3]])
    simulator = Simulator(free, 2)
    for _ in range(3):
        simulator.set_contexts(z, np.array([1]))
    assert differing(simulator.batch.get_model(1), free.compile(z[0])) < 1e-12


def test_a_turn_of_a_body_turns_it_about_its_own_axis() -> None:
    turned = spec()
    Target.parse("body.arm.turn[2]").write(turned, 0.3)
    before, after = (np.zeros(9), np.zeros(9))
    mujoco.mju_quat2Mat(before, spec().compile().body("arm").quat)
    mujoco.mju_quat2Mat(after, turned.compile().body("arm").quat)
    c, s = np.cos(0.3), np.sin(0.3)
    about_z = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    np.testing.assert_allclose(after.reshape(3, 3), before.reshape(3, 3) @ about_z, atol=1e-12)


def test_a_turn_of_an_axis_turns_it_about_the_bodys() -> None:
    turned = spec()
    Target.parse("joint.hinge.turn[0]").write(turned, 0.2)
    x, y, z = spec().compile().joint("hinge").axis
    c, s = np.cos(0.2), np.sin(0.2)
    np.testing.assert_allclose(turned.compile().joint("hinge").axis, [x, c * y - s * z, s * y + c * z], atol=1e-12)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("actuator.motor.time_constant", "has dyntype none, which has no time constant"),
        ("actuator.motor.forcerange[0]", "is not limited. Give it a forcerange"),
        ("body.tipped.turn[0]", "as quat, not as euler"),
    ],
)
def test_what_an_element_does_not_have_is_refused(text: str, told: str) -> None:
    one = spec()
    tipped = one.worldbody.add_body(name="tipped")
    tipped.alt.type, tipped.alt.euler = mujoco.mjtOrientation.mjORIENTATION_EULER, [0.1, 0.0, 0.0]
    with pytest.raises(ModelError, match=told):
        Target.parse(text).read(one)


@pytest.mark.parametrize("text", ["body.framed.pos[0]", "joint.inner.turn[1]"])
def test_what_a_frame_moves_is_refused(text: str) -> None:
    """The compiled model holds other numbers there than the file."""
    framed = """<mujoco><worldbody><frame pos="0.1 0 0" quat="0.6 0 0.8 0"><body name="framed" pos="0.2 0 0">
      <frame quat="0.6 0 0.8 0"><joint name="inner"/></frame><geom size="0.1"/></body></frame></worldbody></mujoco>"""
    with pytest.raises(ModelError, match="stands in a <frame>"):
        Target.parse(text).read(mujoco.MjSpec.from_string(framed))


def test_a_servo_with_a_damping_ratio_keeps_its_gain() -> None:
    """MuJoCo would compute it anew of what the joint carries, and of kp."""
    by_ratio = mujoco.MjSpec.from_string(XML.replace('kv="2"', 'dampratio="0.7"'))
    kv = -by_ratio.compile().actuator("servo").biasprm[2]
    targets = {"mass": "body.arm.mass", "kp": "actuator.servo.kp", "kv": "actuator.servo.kv"}
    declared = {name: {"target": target, "unit": "1", "low": 0.5, "high": 60.0} for name, target in targets.items()}
    model = from_spec("toy", by_ratio, declared)
    np.testing.assert_allclose(model.space.nominal, [2.0, 30.0, kv])
    heavy = np.array([8.0, 60.0, kv])
    np.testing.assert_allclose(model.compile(heavy).actuator("servo").biasprm[:3], [0.0, -60.0, -kv])
    simulator = Simulator(model, 1)
    simulator.set_contexts(heavy[None])
    np.testing.assert_allclose(simulator.batch.expand("actuator_biasprm")[0, 0, :3], [0.0, -60.0, -kv])
