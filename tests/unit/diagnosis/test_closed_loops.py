"""Joints of closed chains that no channel measures, by the closed form of a slider-crank."""

import mujoco
import numpy as np
import pytest
from slider_crank import MJCF, place, rod_angle, slopes

from dr_lab.diagnosis.windows.closed_loops import ClosedLoops
from dr_lab.diagnosis.windows.start import untold_joints
from dr_lab.diagnosis.windows.start_prior import StartPrior
from dr_lab.diagnosis.windows.tangent import tangent
from dr_lab.trajectory import Array

MODEL = mujoco.MjModel.from_xml_string(MJCF.format('solref="0.002 1"'))
CRANK_ALONE, NO_PIN = np.array([True, False, False]), np.array([True, False, True])


@pytest.mark.parametrize("angle", [0.3, -11.2, 5.0])
@pytest.mark.parametrize("known", [CRANK_ALONE, NO_PIN])
def test_what_the_crank_does_the_others_follow(angle: float, known: Array) -> None:
    speed, gain = 2.0, 3.0
    here = np.array(angle)
    (slider, rod), (later, turned) = slopes(here), slopes(here + 1e-6 * speed)
    stands = np.array([angle, float(rod_angle(here)) - angle, float(place(here))])
    bend = np.array([0.0, turned - rod, later - slider]) / 1e-6  # of the slopes, 1/s
    follow = np.array([1.0, rod - 1.0, slider])
    loops = ClosedLoops(MODEL, known.astype(bool))
    found = loops.closed(known * stands, known * follow * speed, known * (follow * gain + bend * speed))
    np.testing.assert_allclose(found.qpos, stands, atol=1e-9)
    np.testing.assert_allclose(found.qvel, follow * speed, atol=1e-8)
    np.testing.assert_allclose(found.qacc, follow * gain + bend * speed, atol=1e-3)
    assert np.abs(loops.constraints(found.qpos)[0]).max() < 1e-12
    np.testing.assert_allclose(found.free, 0.0, atol=1e-6)


def test_measurements_that_no_closed_chain_has_leave_a_gap() -> None:
    loops = ClosedLoops(MODEL, NO_PIN)
    found = loops.closed(np.array([0.3, 0.0, place(np.array(0.3)) + 0.01]), np.zeros(3), np.zeros(3))
    assert np.abs(loops.constraints(found.qpos)[0]).max() == pytest.approx(0.01, rel=0.1)
    q, _ = loops.nearest(found.qpos, np.zeros(3), np.ones(6))
    assert np.abs(loops.constraints(q)[0]).max() < 1e-9


def test_the_nearest_velocities_open_no_chain() -> None:
    loops = ClosedLoops(MODEL, NO_PIN)
    q, v = loops.nearest(np.array([0.3, -0.4, 0.0]), np.array([2.0, 1.0, -1.0]), np.array([1.0, 2.0, 0.5] * 2))
    np.testing.assert_allclose(loops.constraints(q)[1] @ v, 0.0, atol=1e-12)


def test_changes_in_the_tangent_space_open_no_chain_and_others_lose_what_does() -> None:
    loops, angles = ClosedLoops(MODEL, NO_PIN), np.array([0.3, 1.2, -2.0])
    qpos = np.stack([angles, rod_angle(angles) - angles, place(angles)], axis=1)
    found = tangent([loops.constraints(q)[1] for q in qpos], np.array([1e-3, 2e-3, 1e-4, 0.1, 0.2, 0.01]))
    assert found.basis.shape == (3, 6, 2)
    prior = StartPrior(qpos, np.zeros((3, 3)), np.zeros((3, 3)), np.ones(2), found)
    unknowns = np.random.default_rng(1).normal(size=(4, 3, 2))
    change = prior.change(unknowns, np.zeros((4, 3, 6)))
    for each in change:
        for q, row in zip(qpos, each, strict=True):
            jacobian = loops.constraints(q)[1]
            np.testing.assert_allclose(np.stack([jacobian @ row[:3], jacobian @ row[3:]]), 0.0, atol=1e-15)
    np.testing.assert_allclose(prior.unknowns(change), unknowns)
    moved = np.random.default_rng(2).normal(size=(4, 3, 6))
    once = prior.change(0.0 * unknowns, moved)
    np.testing.assert_allclose(prior.change(0.0 * unknowns, once), once)
    slope = np.random.default_rng(3).normal(size=(3, 5, 2))
    np.testing.assert_allclose(prior.slope(slope, change[0]), np.einsum("wms,ws->wm", slope, unknowns[0]))


def test_joints_of_a_chain_move_together() -> None:
    loops, angles = ClosedLoops(MODEL, NO_PIN), np.array([0.3, 1.2, -2.0])
    qpos = np.stack([angles, rod_angle(angles) - angles, place(angles)], axis=1)
    found = tangent([loops.constraints(q)[1] for q in qpos], np.array([1.0, 2.0, 0.1] * 2))
    prior = StartPrior(qpos, np.zeros((3, 3)), np.zeros((3, 3)), np.ones(2), found)
    assert prior.independent([0, 2]) == [0]
    assert prior.independent([2, 0]) == [2]
    slider, rod = slopes(angles)
    expected = np.stack([np.ones(3), rod - 1.0, slider], axis=1)
    np.testing.assert_allclose(prior.carried([0])[..., 0], expected, atol=1e-9)
    for q, each in zip(qpos, expected, strict=True):
        np.testing.assert_allclose(loops.carried(q, [0])[:, 0], each, atol=1e-9)


def test_open_chains_are_left_alone() -> None:
    arm = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body><joint name="one"/><geom size="1"/><body pos="1 0 0"><joint name="two"/>'
        '<geom size="1"/></body></body></worldbody></mujoco>'
    )
    assert not ClosedLoops(arm, np.array([True, False])).closes()
    assert not ClosedLoops(arm, np.array([True, False])).tells()
    assert untold_joints(arm, ["one.position"]) == ("two",)


def test_a_joint_that_the_chain_tells_is_not_missed() -> None:
    assert untold_joints(MODEL, ["crank.position"]) == ()
    assert untold_joints(mujoco.MjModel.from_xml_string(MJCF.format('active="false"')), ["crank.position"]) == (
        "pin",
        "slider",
    )


def test_a_chain_whose_joints_are_all_measured_tells_none() -> None:
    loops = ClosedLoops(MODEL, np.ones(3, bool))
    assert loops.closes()
    assert not loops.tells()


def test_softness_is_told_from_firmness() -> None:
    soft = mujoco.MjModel.from_xml_string(MJCF.format(""))
    assert ClosedLoops(MODEL, NO_PIN).firm()
    assert not ClosedLoops(soft, NO_PIN).firm()


def test_a_finger_that_mimics_another_follows_it() -> None:
    finger = '<body pos="0 {0} 0"><joint name="{1}" type="slide"/><geom size="0.01" mass="0.1"/></body>'
    gripper = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody>{finger.format(0, 'left')}{finger.format(1, 'right')}</worldbody><equality>"
        '<joint joint1="right" joint2="left" polycoef="0.01 -0.5 2 0 0"/></equality></mujoco>'
    )
    found = ClosedLoops(gripper, np.array([True, False])).closed(
        np.array([0.03, 0.0]), np.array([2.0, 0.0]), np.array([5.0, 0.0])
    )
    slope, bend = -0.5 + 4 * 0.03, 4.0
    np.testing.assert_allclose(found.qpos, [0.03, 0.01 - 0.5 * 0.03 + 2 * 0.03**2], atol=1e-12)
    np.testing.assert_allclose(found.qvel, [2.0, 2.0 * slope])
    np.testing.assert_allclose(found.qacc, [5.0, 5.0 * slope + bend * 2.0**2], rtol=1e-5)
    assert untold_joints(gripper, ["left.position"]) == ()
