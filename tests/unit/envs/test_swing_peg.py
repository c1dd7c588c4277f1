"""Swing-peg: kinematics, masses, period, servos, reward, and contexts that act as a compiled model does."""

from collections.abc import Mapping
from typing import cast

import mujoco
import numpy as np
import pytest
from scipy.linalg import eigh
from settings import setting

from dr_lab.envs.episodes import Episodes
from dr_lab.envs.setting import Setting
from dr_lab.envs.task import Change
from dr_lab.envs.tasks.swing_peg import SwingPeg
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

OF: Setting = setting("swing_peg")
FREE: Setting = setting(
    "swing_peg",
    "env/context=[swing_peg/joints,swing_peg/action_scaling,swing_peg/rope,swing_peg/rope_twist,swing_peg/peg]",
)
# alpha rad, a m, d m, theta rad: ABB_YuMI_IRB_14050 in robotkinematicscatalogue 1.1.2 (modified Denavit-Hartenberg)
TABLE = (
    (0.0, 0.0, 0.305, 0.0),
    (-np.pi / 2, -0.03, 0.0, 0.0),
    (np.pi / 2, 0.03, 0.2515, 0.0),
    (-np.pi / 2, 0.0405, 0.0, np.pi / 2),
    (np.pi / 2, -0.0405, 0.265, 0.0),
    (-np.pi / 2, 0.027, 0.0, 0.0),
    (np.pi / 2, -0.027, 0.036, 0.0),
)
SEGMENTS, LENGTH, SEGMENT_MASS = 8, 0.016, 2500 * np.pi * 0.002**2 * 0.016
PEG_LENGTH, PEG_RADIUS = 0.1, 0.015
PEG_MASS = 400 * np.pi * PEG_RADIUS**2 * (0.07 + 4 / 3 * PEG_RADIUS)


def task() -> SwingPeg:
    return cast(SwingPeg, OF.task)


def episodes(context: Mapping[str, float] | None = None) -> Episodes:
    of = OF if context is None else FREE
    made = of.make(None, 1, 0, threads=1).episodes
    made.give_contexts(of.space.vector(context or {})[None])
    made.begin(np.arange(1), resting(made))
    return made


def resting(made: Episodes) -> tuple[Array, Array]:
    compiled = made.simulator.compiled
    return compiled.qpos_spring[None].copy(), np.zeros((1, compiled.nv))


def turned(axis: int, angle: float) -> Array:
    found, (i, j) = np.eye(4), [k for k in range(3) if k != axis]
    sign = -1.0 if axis == 1 else 1.0
    found[[i, i, j, j], [i, j, i, j]] = np.cos(angle), -sign * np.sin(angle), sign * np.sin(angle), np.cos(angle)
    return found


def moved(x: float, z: float) -> Array:
    found = np.eye(4)
    found[[0, 2], 3] = x, z
    return found


def flange(angles: Array) -> Array:
    """From the first axis' foot, as the published table has it; its first joint and flange are half a turn away."""
    place = turned(2, np.pi)
    for (alpha, a, d, theta), angle in zip(TABLE, angles, strict=True):
        place = place @ turned(0, alpha) @ moved(a, 0.0) @ turned(2, theta + angle) @ moved(0.0, d)
    return place @ turned(2, np.pi)


def test_the_flange_is_where_the_published_table_has_it() -> None:
    compiled = OF.model.nominal()
    data, rng = mujoco.MjData(compiled), np.random.default_rng(0)
    low, high = compiled.jnt_range[:7].T
    poses = [np.zeros(7), *rng.uniform(low, high, (20, 7))]
    for pose in poses:
        data.qpos[:7] = pose
        mujoco.mj_kinematics(compiled, data)
        foot, gripper = np.eye(4), np.eye(4)
        for found, name in ((foot, "link_1"), (gripper, "gripper")):
            found[:3, :3], found[:3, 3] = data.body(name).xmat.reshape(3, 3), data.body(name).xpos
        foot[:3, :3] = foot[:3, :3] @ turned(2, -pose[0])[:3, :3]  # as it is before the first joint turns
        expected = flange(pose) - np.eye(4)[:, [2]] * (TABLE[0][2] - 0.1) * np.eye(4)[3]  # 0.1 m to the second axis
        np.testing.assert_allclose(np.linalg.inv(foot) @ gripper, expected, atol=2e-6)


def test_it_weighs_what_is_stated() -> None:
    compiled = OF.model.nominal()
    mass = {compiled.body(i).name: float(compiled.body_mass[i]) for i in range(compiled.nbody)}
    assert sum(mass[f"link_{i}"] for i in range(1, 8)) == pytest.approx(9.5, rel=1e-4)
    assert mass["gripper"] == pytest.approx(0.22)
    for i in range(1, SEGMENTS + 1):
        assert mass[f"rope_{i}"] == pytest.approx(SEGMENT_MASS, rel=1e-4)
    assert mass["peg"] == pytest.approx(PEG_MASS, rel=1e-4)


def slowest_period(weight: float = 9.81) -> float:
    """Of small swings of a chain of rods: M q'' + K q = 0 in the angles q to the vertical.

    M_jk = Σ_i m_i c_ij c_ik + δ_jk I_j and K_j = g Σ_i m_i c_ij, c_ij being the lever of rod j on the centre of rod i.
    """
    lengths, masses = np.array([LENGTH] * SEGMENTS + [PEG_LENGTH]), np.array([SEGMENT_MASS] * SEGMENTS + [PEG_MASS])
    lever = np.tril(np.tile(lengths, (SEGMENTS + 1, 1)), -1) + np.diag(lengths / 2)
    inertia = masses * lengths**2 / 12
    inertia[-1] = OF.model.nominal().body("peg").inertia[0]
    mass = lever.T @ np.diag(masses) @ lever + np.diag(inertia)
    frequencies = eigh(weight * np.diag(masses @ lever), mass, eigvals_only=True)
    return float(2 * np.pi / np.sqrt(frequencies[0]))


def test_the_peg_swings_as_a_chain_of_rods_does() -> None:
    made = episodes({"rope.bending_damping": 0.0, "rope.bending_stiffness": 1e-5})
    qpos, qvel = resting(made)
    qpos[0, 7] = 0.05
    made.begin(np.arange(1), (qpos, qvel))
    course = []
    for _ in range(140):
        made.step(np.zeros((1, 7)))
        course.append(made.simulator.batch.bind("site_xpos")[0, 1].copy())
    away = np.array(course) - np.mean(course, axis=0)
    along = away @ np.linalg.svd(away)[2][0]
    ends = np.flatnonzero(np.diff(np.sign(along)))
    crossings = ends + along[ends] / (along[ends] - along[ends + 1])
    period = 2 * OF.seconds * np.mean(np.diff(crossings))
    assert len(crossings) >= 5
    assert period == pytest.approx(slowest_period(), rel=0.02)


@pytest.mark.parametrize("scaling", [0.5, 0.3])
def test_a_joint_turns_at_its_action_scaling(scaling: float) -> None:
    made = episodes({"joint_6.action_scaling": scaling})
    before = made.state[0][0, 6]
    for _ in range(50):
        made.step(np.array([[0.0] * 6 + [1.0]]))
    assert made.state[0][0, 6] - before == pytest.approx(scaling, abs=0.02)  # 1 s less the servo's delay, 7 ms


def test_the_reward_is_of_both_ends_of_the_peg_and_of_the_action() -> None:
    goals, away = np.array([[0.1, 0.2, 0.3], [0.4, 0.0, -0.1]]), np.array([[0.03, -0.04, 0.0], [0.0, 0.0, 0.12]])
    sites = np.zeros((1, 6, 3))
    sites[0, [5, 4]], sites[0, [0, 2]] = goals, goals + away
    fields = {"qpos": np.zeros((1, 24)), "site_xpos": sites, "sensordata": np.zeros((1, 3))}
    fields["site_xmat"] = np.tile(np.eye(3).ravel(), (1, 6, 1))
    action, nothing = np.full((1, 7), 0.5), np.empty((1, 0))
    distance = 10.0 * (0.07 + 0.12) / 2 + 4.0 * (0.05 + 0.12) / 2
    for depth, bonus in ((0.01, 0.1), (-0.01, 0.0)):
        sites[0, 1] = sites[0, 3] + [0.0, 0.01, -depth]
        change = Change(nothing, nothing, fields, {}, np.zeros(1, bool), action, OF.seconds)
        assert task().reward(change)[0] == pytest.approx(bonus - distance - 0.7 * 0.25)


def test_it_is_solved_where_the_middle_of_the_peg_is_within_the_hole() -> None:
    seen = np.zeros((4, 13))
    seen[:, 7:10] = [[0.0, 0.01, -0.001], [0.0, 0.0, 0.001], [0.026, 0.0, -0.01], [0.0, 0.024, -0.03]]
    assert list(task().solved(seen)) == [True, False, False, True]


def test_the_place_before_is_that_of_one_control_step_ago() -> None:
    made = episodes()
    qpos, qvel = resting(made)
    qpos[0, 7:9] = 0.3
    made.begin(np.arange(1), (qpos, qvel))
    seen = np.array([made.step(np.zeros((1, 7))).observation[0] for _ in range(60)])
    assert np.ptp(seen[:, 7:10], axis=0).max() > 0.03
    np.testing.assert_allclose(seen[1:, 10:], seen[:-1, 7:10], atol=2e-3)


def test_the_hole_is_as_wide_as_the_context_says_and_wider_than_the_peg() -> None:
    sized = setting("swing_peg", "env/context=[swing_peg/peg,swing_peg/peg_radius]")
    low, high = (dict(zip(sized.space.names, end, strict=True)) for end in (sized.space.low, sized.space.high))
    assert low["hole.half_width"] > OF.model.nominal().geom("peg").size[0]
    assert OF.model.nominal().body("wall_1").pos[0] > OF.model.nominal().geom("peg").size[0]
    assert 0.5 * (low["hole.half_width"] + high["hole.half_width"]) > high["peg.radius"]
    made, width = episodes({"hole.half_width": 0.02}), []
    places = made.simulator.batch.bind("geom_xpos")[0]
    made.step(np.zeros((1, 7)))
    half = OF.model.nominal().geom("wall_1").size[0]
    for one, other in (("wall_1", "wall_3"), ("wall_2", "wall_4")):
        ids = [made.simulator.compiled.geom(name).id for name in (one, other)]
        width.append(np.linalg.norm(places[ids[0]] - places[ids[1]]) - 2 * half)
    np.testing.assert_allclose(width, 0.04, atol=1e-6)


def test_contexts_written_as_fields_move_as_compiled_ones_do() -> None:
    z = FREE.space.from_unit(np.random.default_rng(0).uniform(0.3, 0.7, len(FREE.space.names)))
    simulator, compiled = Simulator(FREE.model, 1, threads=1), FREE.model.compile(z)
    simulator.set_contexts(z[None])
    simulator.reset()
    data = mujoco.MjData(compiled)
    for qpos in (simulator.batch.bind("qpos")[0], data.qpos):
        qpos[:] = compiled.qpos_spring
        qpos[7] = 0.4
    for k in range(200):
        data.ctrl[:] = np.sin(0.02 * k + np.arange(7))
        simulator.step(data.ctrl[None].copy())
        mujoco.mj_step(compiled, data)
    np.testing.assert_allclose(simulator.batch.bind("qpos")[0], data.qpos, atol=1e-7)


def test_its_time_step_is_fine_enough() -> None:
    places = []
    for parts in (1, 10):
        compiled = OF.model.nominal()
        compiled.opt.timestep /= parts
        data, course = mujoco.MjData(compiled), list[Array]()
        data.qpos[:] = compiled.qpos_spring
        data.qpos[7] = 0.1
        for k in range(150):
            data.ctrl[:] = 0.6 * np.sin(0.08 * k + 1.3 * np.arange(7))
            mujoco.mj_step(compiled, data, 4 * parts)
            mujoco.mj_kinematics(compiled, data)
            course.append(data.site("peg").xpos.copy())
        places.append(np.array(course))
    assert np.ptp(places[1], axis=0).max() > 0.1
    np.testing.assert_allclose(*places, rtol=0, atol=5e-4)


def test_it_starts_at_rest_near_its_pose_with_a_swinging_rope() -> None:
    qpos, qvel = OF.make(None, 200, 0, threads=1).episodes.state
    rest = OF.model.nominal().qpos_spring
    assert (np.abs(qpos[:, :7] - rest[:7]) <= 0.02).all()
    assert (np.abs(qpos[:, 7:9]) <= 0.1).all()
    assert np.ptp(qpos[:, 7]) > 0.15
    assert not qvel.any()
    assert not qpos[:, 9:].any()
