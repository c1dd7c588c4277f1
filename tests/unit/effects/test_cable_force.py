import mujoco
import numpy as np
import pytest
from effect_machines import CONF, catalogue_effect, energies, scales_of, with_effect

from dr_lab.effects.effect import place
from dr_lab.physics.model import Model, load
from dr_lab.trajectory import Array

STIFFNESS, LENGTH = 40.0, 0.25  # N/m, m
ANCHOR = np.array([0.5, 0.0, 0.7])  # m; in the plane of the arm


def elbow() -> Model:
    return load("elbow", CONF / "model" / "strangers" / "elbow.xml", {})


def cabled(length: float = LENGTH, stiffness: float = STIFFNESS) -> mujoco.MjModel:
    anchor = {f"anchor_{axis}": float(each) for axis, each in zip("xyz", ANCHOR, strict=True) if axis != "y"}
    return with_effect(elbow(), "cable_force", "forearm", stiffness=stiffness, length=length, **anchor)


def passive(model: mujoco.MjModel, q: list[float]) -> tuple[Array, Array, Array]:
    """Generalised forces without velocity, the forearm's centre and its Jacobian."""
    data, body = mujoco.MjData(model), model.body("forearm").id
    data.qpos[:] = q
    mujoco.mj_forward(model, data)
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jacBodyCom(model, data, jacobian, None, body)
    return data.qfrc_passive.copy(), data.xipos[body].copy(), jacobian


@pytest.mark.parametrize("q", [[0.3, 0.7], [-1.0, 0.2], [-2.0, 1.0]])
@pytest.mark.parametrize("length", [0.0, LENGTH])
def test_the_centre_is_pulled_towards_the_anchor(q: list[float], length: float) -> None:
    force, centre, jacobian = passive(cabled(length), q)
    way = ANCHOR - centre
    far = float(np.linalg.norm(way))
    assert far > length
    np.testing.assert_allclose(force, jacobian.T @ (STIFFNESS * (far - length) * way / far), rtol=1e-9)


def test_a_slack_cable_pulls_nothing() -> None:
    force, centre, _ = passive(cabled(length=5.0), [0.3, 0.7])
    assert np.linalg.norm(ANCHOR - centre) < 5.0
    np.testing.assert_array_equal(force, 0.0)


def test_energy_is_kept() -> None:
    energy = energies(cabled(), [0.8, -0.5], [2.0, 1.0])
    assert np.ptp(energy) < 1e-4 * abs(energy[0])


def test_without_stiffness_it_is_absent() -> None:
    plain, absent = elbow().nominal(), cabled(stiffness=0.0)
    for q in ([0.3, 0.7], [-1.0, 0.2]):
        np.testing.assert_array_equal(passive(absent, q)[0], passive(plain, q)[0])


def test_bodies_that_fly_only_slide_or_turn_about_their_centre_have_none() -> None:
    effect = catalogue_effect("cable_force")
    assert effect.sites(elbow().nominal()) == ("upper_arm", "forearm")
    flying = "<mujoco><worldbody><body name='b'><freejoint/><geom size='0.1'/></body></worldbody></mujoco>"
    assert effect.sites(mujoco.MjModel.from_xml_string(flying)) == ()
    wheel = "<mujoco><worldbody><body name='b'><joint/><geom size='0.1' pos='1e-17 0 0'/></body></worldbody></mujoco>"
    assert effect.sites(mujoco.MjModel.from_xml_string(wheel)) == ()
    assert effect.sites(load("cartpole", CONF / "model" / "cartpole.xml", {}).nominal()) == ("pole",)


def test_bounds_grow_with_the_machine() -> None:
    model, arm = elbow().nominal(), scales_of(elbow(), torque=3.0)
    stiffness, *anchor, length = place(catalogue_effect("cable_force"), model, "forearm", arm).parameters
    _, centre, _ = passive(model, [0.0, 0.0])
    reach = np.linalg.norm(model.body("forearm").pos) + np.linalg.norm(model.body("forearm").ipos)
    assert stiffness.high == pytest.approx(2.0 * 3.0 / reach**2)
    np.testing.assert_allclose([each.nominal for each in anchor], centre[[0, 2]])
    np.testing.assert_allclose([each.high - each.nominal for each in anchor], 4.0 * reach)
    assert length.high == pytest.approx(4.0 * reach)


def test_fits_start_from_several_anchors_with_a_cable_that_is_never_slack() -> None:
    model = elbow().nominal()
    one = place(catalogue_effect("cable_force"), model, "forearm", scales_of(elbow(), torque=3.0))
    stiffness, *anchor, length = one.parameters
    reach = length.high / 4.0
    moved = [[start[p.name] - p.nominal for p in anchor] for start in one.starts]
    np.testing.assert_allclose(moved, reach * np.array([[0, 0], [2, 0], [0, -2]]))
    assert {start[stiffness.name] for start in one.starts} == {0.1 * stiffness.high}
    assert all(length.name not in start for start in one.starts)
