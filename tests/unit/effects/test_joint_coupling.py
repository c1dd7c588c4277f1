import mujoco
import numpy as np
import pytest
from effect_machines import CONF, block, catalogue_effect, energies, hanging, scales_of, with_effect

from dr_lab.effects.effect import place
from dr_lab.physics.model import Model, from_spec, load

STIFFNESS, RATIO, REST = 2.0, 0.5, 0.1  # N·m/rad; 1; rad


def elbow() -> Model:
    return load("elbow", CONF / "model" / "strangers" / "elbow.xml", {})


def coupled() -> mujoco.MjModel:
    return with_effect(elbow(), "joint_coupling", "elbow", stiffness=STIFFNESS, ratio=RATIO, rest=REST)


def test_both_joints_feel_the_spring() -> None:
    model = coupled()
    data = mujoco.MjData(model)
    for q in ([0.3, 0.7], [-1.0, 0.2], [0.0, 0.0]):
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        stretch = q[0] - RATIO * q[1] - REST
        np.testing.assert_allclose(data.qfrc_passive, [-STIFFNESS * stretch, RATIO * STIFFNESS * stretch], rtol=1e-9)


def test_a_rest_of_minus_one_is_a_number_like_others() -> None:
    """MuJoCo takes a springlength of -1 for one that nobody gave."""
    model = with_effect(elbow(), "joint_coupling", "elbow", stiffness=STIFFNESS, ratio=RATIO, rest=-1.0)
    data = mujoco.MjData(model)
    data.qpos[:] = [0.3, 0.7]
    mujoco.mj_forward(model, data)
    assert data.qfrc_passive[0] == pytest.approx(-STIFFNESS * (0.3 - RATIO * 0.7 + 1.0))


def test_the_files_default_tendon_is_another_one() -> None:
    spec = mujoco.MjSpec.from_file(str(CONF / "model" / "strangers" / "elbow.xml"))
    default = spec.default.tendon
    default.frictionloss, default.armature, default.limited, default.range = 0.5, 0.2, True, [0.0, 0.1]
    default.damping = [1.0, 0.0, 0.0]
    for name, site in (("joint_coupling", "elbow"), ("cable_force", "forearm")):
        found = energies(with_effect(from_spec("elbow", spec, {}), name, site), [0.8, -0.5], [2.0, 1.0])
        np.testing.assert_array_equal(found, energies(with_effect(elbow(), name, site), [0.8, -0.5], [2.0, 1.0]))


def test_energy_is_kept() -> None:
    energy = energies(coupled(), [0.8, -0.5], [2.0, 1.0])
    assert np.ptp(energy) < 1e-4 * abs(energy[0])


def test_a_stiff_belt_holds_a_forearm_level() -> None:
    """With r = −1 and a zero rest the elbow does the opposite of the shoulder."""
    model = with_effect(elbow(), "joint_coupling", "elbow", stiffness=2000.0, ratio=-1.0, rest=0.0)
    data = mujoco.MjData(model)
    data.qpos[:] = [0.7, -0.7]
    for _ in range(400):
        mujoco.mj_step(model, data)
    assert abs(data.qpos[0]) > 0.05
    assert data.qpos.sum() == pytest.approx(0.0, abs=5e-3)


def test_neighbours_of_one_kind_are_coupled() -> None:
    effect = catalogue_effect("joint_coupling")
    assert effect.sites(elbow().nominal()) == ("elbow",)
    assert effect.sites(hanging().nominal()) == effect.sites(block().nominal()) == ()
    assert effect.sites(load("cartpole", CONF / "model" / "cartpole.xml", {}).nominal()) == ()


def test_bounds_grow_with_the_machine() -> None:
    one = place(catalogue_effect("joint_coupling"), elbow().nominal(), "elbow", scales_of(elbow(), torque=3.0))
    stiffness, ratio, rest = one.parameters
    assert (stiffness.low, stiffness.high) == pytest.approx((0.0, 6.0))  # 2 · 3 N·m over 1 rad
    assert (ratio.low, ratio.high, rest.high) == pytest.approx((-3.0, 3.0, 2.0))  # 0.5 + 3 · 0.5 rad
    assert [start["joint_coupling@elbow.ratio"] for start in one.starts] == [1.0, -1.0]
