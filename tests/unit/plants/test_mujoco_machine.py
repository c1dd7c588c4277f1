"""What alters a machine that MuJoCo works out, against the parallel-axis theorem and laws of contact."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
from effect_machines import with_effect
from scipy.optimize import root_scalar

from dr_lab.errors import ConfigError
from dr_lab.physics.model import load
from dr_lab.plants.hidden.armature import Armature
from dr_lab.plants.hidden.contact_friction import ContactFriction
from dr_lab.plants.hidden.contact_stiffness import ContactStiffness
from dr_lab.plants.hidden.creeping_friction import CreepingFriction
from dr_lab.plants.hidden.joint_coupling import JointCoupling
from dr_lab.plants.hidden.link_length import LinkLength
from dr_lab.plants.hidden.rigid_payload import RigidPayload
from dr_lab.plants.hidden.torque_scale import TorqueScale
from dr_lab.plants.mujoco_machine import MujocoMachine, MujocoNominal
from dr_lab.trajectory import Array

MODELS = Path(__file__).parents[3] / "conf" / "model"
POSITION, VELOCITY = [0.3, -1.2, 1.1, -0.7, 0.9, 0.4], [1.0, -2.0, 0.5, 1.5, -1.0, 2.0]
NONE = [0.0] * 6
WRIST = """<mujoco><compiler angle="radian"/><worldbody>
  <body name="wrist"><joint name="bend" axis="0 1 0"/><joint name="tilt" axis="1 0 0" pos="0 0.02 0"/>
    <inertial pos="0.1 0.05 0.2" mass="1" diaginertia="0.02 0.02 0.02"/>
    <body name="hand" pos="0.2 0.32 0.4"><joint name="grip" axis="0 0 1"/>
      <inertial pos="0.1 0 0" mass="0.5" diaginertia="0.01 0.01 0.01"/></body></body></worldbody></mujoco>"""


def nominal(name: str, *free: str) -> MujocoNominal:
    return MujocoNominal(mjcf=str(MODELS / f"{name}.xml"), free=free, spread=0.15)


def arm() -> MujocoMachine:
    return nominal("arm").machine({})


def bouncer() -> MujocoMachine:
    return nominal("bouncer", "carriage.damping", "foot.damping").machine(
        {"carriage.damping": 0.0, "foot.damping": 0.0}
    )


def terms(machine: MujocoMachine) -> tuple[Array, Array]:
    mass, force = machine.terms(POSITION, VELOCITY, NONE, NONE)
    return np.array(mass), np.array(force)


def test_a_load_is_a_body_of_its_own() -> None:
    spec = mujoco.MjSpec.from_file(str(MODELS / "arm.xml"))
    # The forearm's centre lies at −x from its joint; its offset along the axis does not count.
    load = spec.body("forearm").add_body(pos=[-0.15, 0, 0], mass=0.4, explicitinertial=True)
    load.ipos, load.iquat, load.inertia = [0, 0, 0], [1, 0, 0, 0], [0, 0, 0]
    expected = terms(MujocoMachine.of(spec.compile()))
    for found, known in zip(terms(arm().with_load("forearm", 0.4, 0.15)), expected, strict=True):
        np.testing.assert_allclose(found, known, rtol=0, atol=1e-9)


def test_four_points_are_a_rigid_body() -> None:
    """Points at ± a and ± b about a centre: a body whose moments are those of two dumb-bells."""
    a, b, centre = 0.05, 0.08, np.array([-0.1, 0.04, 0.03])
    ends = [centre + step for step in ([a, 0, 0], [-a, 0, 0], [0, b, 0], [0, -b, 0])]
    spec = mujoco.MjSpec.from_file(str(MODELS / "arm.xml"))
    load = spec.body("forearm").add_body(pos=centre, mass=0.8, explicitinertial=True)
    load.ipos, load.iquat = [0, 0, 0], [1, 0, 0, 0]
    load.inertia = [0.4 * b**2, 0.4 * a**2, 0.4 * (a**2 + b**2)]
    expected = terms(MujocoMachine.of(spec.compile()))
    found = RigidPayload("forearm", [0.2] * 4, [end.tolist() for end in ends]).alter(arm())
    assert isinstance(found, MujocoMachine)
    for ours, known in zip(terms(found), expected, strict=True):
        np.testing.assert_allclose(ours, known, rtol=0, atol=1e-9)


def test_masses_carry_their_inertia_along() -> None:
    heavier = nominal("arm", "forearm.mass", "elbow.damping").machine({"forearm.mass": 2.874, "elbow.damping": 3.0})
    assert heavier.model.body("forearm").mass[0] == pytest.approx(2 * 1.437)
    np.testing.assert_allclose(heavier.model.body("forearm").inertia, 2 * arm().model.body("forearm").inertia)
    assert heavier.model.joint("elbow").damping[0] == 3.0


def test_armature_and_drive_enter_where_they_should() -> None:
    mass, force = terms(arm())
    loaded = Armature("wrist_2", 0.03).alter(arm()).terms(POSITION, VELOCITY, NONE, NONE)[0]
    np.testing.assert_allclose(np.array(loaded) - mass, np.diag([0, 0, 0, 0, 0.03, 0]), rtol=0, atol=1e-12)
    weaker = TorqueScale(0.8, site="elbow").alter(arm()).terms(POSITION, VELOCITY, [5.0] * 6, NONE)[1]
    np.testing.assert_allclose(np.array(weaker) - force, [5, 5, 4, 5, 5, 5], rtol=0, atol=1e-9)


def test_a_weak_position_controller_pulls_and_brakes_less() -> None:
    servo = nominal("strangers/elbow_servo").machine({})
    q, v, target, none = [0.3, -0.2], [1.0, -2.0], [0.5, 0.1], [0.0, 0.0]
    full, weak = (np.array(m.terms(q, v, target, none)[1]) for m in (servo, servo.with_drive_scaled("shoulder", 0.7)))
    pull = 60.0 * (target[0] - q[0]) - 2.5 * v[0]  # kp, kv of the file
    np.testing.assert_allclose(weak - full, [-0.3 * pull, 0.0], rtol=0, atol=1e-9)


def contact(machine: MujocoMachine, depth: float, speed: float, lift: float) -> Array:
    """Force on carriage and foot in N at a depth in m, sliding at a speed in m/s under a lift in N."""
    return np.array(machine.terms([0.0, -depth], [speed, 0.0], [0.0, lift], [0.0, 0.0])[1])


@pytest.mark.parametrize("factor", [1.0, 0.6])
def test_a_sliding_foot_feels_friction_times_its_weight(factor: float) -> None:
    machine = bouncer() if factor == 1 else ContactFriction("foot", factor).alter(bouncer())
    assert isinstance(machine, MujocoMachine)
    depth = float(root_scalar(lambda r: contact(machine, r, 0.5, 0.0)[1], bracket=(1e-5, 0.02), xtol=1e-14).root)
    assert contact(machine, depth, 0.5, 0.0)[0] == pytest.approx(-factor * 0.5 * 0.5 * 9.81, rel=1e-6)


def test_stiffness_is_the_inverse_square_of_both_times() -> None:
    machine, other = bouncer(), ContactStiffness("foot", 1.3, 0.7).alter(bouncer())
    assert isinstance(other, MujocoMachine)
    # Beyond 8 mm the impedance is constant; the lift takes the weight off.
    stiff, soft = (contact(m, 0.01, 0.0, 0.5 * 9.81)[1] for m in (machine, other))
    assert stiff > 1.0
    assert soft / stiff == pytest.approx((1.3 * 0.7) ** -2, rel=1e-9)


def test_creeping_friction_is_coulombs_but_for_a_creep() -> None:
    friction = CreepingFriction("carriage", 2.0, 1e-4)
    assert friction.force(0.0, 0.0, 0.01) == pytest.approx(-2.0)
    assert friction.force(0.0, 0.0, -1e-5) == pytest.approx(0.2, rel=0.01)
    assert friction.label == "coulomb_friction@carriage"


def test_a_machine_without_contacts_has_no_contact_effect() -> None:
    with pytest.raises(ConfigError, match="plant=bouncer"):
        ContactFriction("tail", 0.5).alter(bouncer())


def test_a_cable_pulls_at_both_pulleys_with_its_tension() -> None:
    """T = 500 N/m · (0.05 m · 0.3 − (−0.02 m) · 1.1 − 0.01 m) = 13.5 N, on 5 cm at one joint and 2 cm at the other."""
    hidden = JointCoupling("elbow", "shoulder_pan", stiffness=500.0, radius=0.05, own_radius=-0.02, slack=0.01)
    (_, before), (_, after) = terms(arm()), terms(MujocoMachine.of(arm().model))
    np.testing.assert_array_equal(before, after)
    altered = hidden.alter(arm())
    assert isinstance(altered, MujocoMachine)
    added = terms(altered.with_gravity(altered.gravity))[1] - before
    where = [arm().joints.index(joint) for joint in ("shoulder_pan", "elbow")]
    np.testing.assert_allclose(added[where], [-13.5 * 0.05, -13.5 * 0.02], rtol=1e-9)
    assert np.count_nonzero(np.abs(added) > 1e-9) == 2


def test_a_longer_link_carries_the_rest_farther_out() -> None:
    plain = nominal("strangers/elbow").machine({})
    longer = LinkLength("forearm", 0.05).alter(plain)
    assert isinstance(longer, MujocoMachine)
    assert (plain.link("forearm"), longer.link("forearm"), plain.link("upper_arm")) == pytest.approx((0.3, 0.35, 0.0))
    at, still = [0.3, 0.9], [0.0, 0.0]
    change = np.array(longer.terms(at, still, still, still)[0]) - np.array(plain.terms(at, still, still, still)[0])
    across = 0.05 * 0.6 * 0.16 * np.cos(0.9)  # kg·m²: m L c cos φ with a longer L
    np.testing.assert_allclose(change, [[0.6 * (0.35**2 - 0.3**2) + 2 * across, across], [across, 0.0]], atol=1e-9)


def test_a_link_and_a_load_of_several_hinges_hang_on_the_last_as_the_catalogues_do(tmp_path: Path) -> None:
    """Only the last hinge rests in the body's frame."""
    (tmp_path / "wrist.xml").write_text(WRIST)
    plain = MujocoNominal(mjcf=str(tmp_path / "wrist.xml"), free=(), spread=0.0).machine({})
    model = load("wrist", tmp_path / "wrist.xml", {})
    assert plain.bodies == ("wrist", "hand")
    longer = with_effect(model, "link_length", "hand", excess=0.05)
    assert plain.link("hand") == pytest.approx(0.5)  # across the hinge about x, which comes last
    np.testing.assert_allclose(plain.with_link_longer("hand", 0.05).model.body("hand").pos, longer.body("hand").pos)
    loaded = with_effect(model, "payload", "wrist", mass=0.2, distance=0.1)
    at, moving, still = [0.3, -0.7, 0.4], [1.0, -2.0, 0.5], [0.0, 0.0, 0.0]
    terms = plain.with_load("wrist", 0.2, 0.1).terms(at, moving, [], still)
    theirs = MujocoMachine.of(loaded).terms(at, moving, [], still)
    np.testing.assert_allclose(np.array(terms[0]), np.array(theirs[0]), rtol=1e-9)
    np.testing.assert_allclose(terms[1], theirs[1], rtol=1e-9, atol=1e-12)
