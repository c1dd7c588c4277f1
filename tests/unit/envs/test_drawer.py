"""The drawer: an arm of published kinematics and masses, its servos, the drawer's travel, and the reward."""

from collections.abc import Mapping

import mujoco
import numpy as np
import pytest
from settings import setting

from dr_lab.envs.episodes import Episodes
from dr_lab.trajectory import Array

# Denavit-Hartenberg parameters of the Panda, Craig's convention: a m, d m, alpha rad; the flange is the last
CHAIN = (
    (0.0, 0.333, 0.0),
    (0.0, 0.0, -np.pi / 2),
    (0.0, 0.316, np.pi / 2),
    (0.0825, 0.0, np.pi / 2),
    (-0.0825, 0.384, -np.pi / 2),
    (0.0, 0.0, np.pi / 2),
    (0.088, 0.0, np.pi / 2),
    (0.0, 0.107, 0.0),
)
MASSES = (4.970684, 0.646926, 3.228604, 3.587895, 1.225946, 1.666555, 0.735522)  # kg, of the links (Gaz et al. 2019)
HAND = 0.73 + 2 * 0.015  # kg
READY = (0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4)  # rad; Franka's, far from the cabinet
GRASPING = (0.0, 0.1516, 0.0, -1.8123, 0.0, 3.5347, -0.7853)  # rad; the bar of the closed drawer between the fingers
EVERYTHING = "env/context=[drawer/cabinet,drawer/joints,drawer/gripper,drawer/drawer,drawer/scales]"


def flange(angles: Array) -> Array:
    """Its pose as a 4x4 matrix, link by link."""
    pose = np.eye(4)
    for (a, d, alpha), angle in zip(CHAIN, [*angles, 0.0], strict=True):
        c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(alpha), np.sin(alpha)
        pose @= np.array([[c, -s, 0, a], [s * ca, c * ca, -sa, -d * sa], [s * sa, c * sa, ca, d * ca], [0, 0, 0, 1]])
    return pose


def machine() -> tuple[mujoco.MjModel, mujoco.MjData]:
    compiled = setting("drawer").model.nominal()
    return compiled, mujoco.MjData(compiled)


def episodes(*overrides: str, slots: int = 1, context: Mapping[str, float] | None = None) -> Episodes:
    of = setting("drawer", *overrides)
    made = of.make(None, slots, 0, threads=1).episodes
    made.give_contexts(np.tile(of.space.vector(context or {}), (slots, 1)))
    made.begin(np.arange(slots))
    return made


def test_the_flange_is_where_the_published_chain_ends() -> None:
    compiled, data = machine()
    low, high = compiled.jnt_range[:7].T
    poses = np.vstack([np.zeros(7), np.random.default_rng(0).uniform(low, high, (5, 7))])
    for angles in poses:
        data.qpos[:7] = angles
        mujoco.mj_kinematics(compiled, data)
        np.testing.assert_allclose(data.site("flange").xpos, flange(angles)[:3, 3], atol=1e-9)
        np.testing.assert_allclose(data.site("flange").xmat.reshape(3, 3), flange(angles)[:3, :3], atol=1e-9)
    np.testing.assert_allclose(flange(poses[0])[:3, 3], [0.088, 0.0, 0.333 + 0.316 + 0.384 - 0.107], atol=1e-12)


def test_the_arm_weighs_what_was_identified() -> None:
    compiled, _ = machine()
    assert compiled.body("link1").subtreemass[0] == pytest.approx(sum(MASSES) + HAND)


def test_gravity_is_compensated_wherever_the_arm_is() -> None:
    compiled, data = machine()
    data.qpos[:7] = np.random.default_rng(1).uniform(compiled.jnt_range[:7, 0], compiled.jnt_range[:7, 1])
    mujoco.mj_forward(compiled, data)
    assert np.abs(data.qfrc_bias[:7]).max() > 1.0
    np.testing.assert_allclose(data.qfrc_passive[:9], data.qfrc_bias[:9], atol=1e-12)


def test_a_free_arm_keeps_its_energy() -> None:
    compiled, data = machine()
    compiled.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
    compiled.opt.integrator, compiled.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, 1e-3
    compiled.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    compiled.dof_damping[:] = 0.0  # of the fingers
    data.qpos[:7], data.qpos[7:9] = setting("drawer").task.pose, 0.02  # pyright: ignore[reportAttributeAccessIssue]
    data.qvel[:7] = [-0.5, -0.4, 0.3, 0.2, 0.5, -0.5, 0.4]
    energies = []
    for _ in range(300):
        mujoco.mj_step(compiled, data)
        energies.append(data.energy[1])
    assert np.abs(data.qvel[:7] - [-0.5, -0.4, 0.3, 0.2, 0.5, -0.5, 0.4]).max() > 0.05
    np.testing.assert_allclose(energies, energies[0], rtol=1e-8)  # gravity is compensated, so all of it is kinetic


def test_the_servos_hold_the_arm_where_it_began() -> None:
    made = episodes(slots=2)
    began = made.state[0]
    for _ in range(50):
        made.step(np.tile([0.0] * 7 + [1.0], (2, 1)))
    np.testing.assert_allclose(made.state[0], began, atol=1e-6)


def test_actions_are_shares_of_the_joints_velocities() -> None:
    made = episodes(EVERYTHING, context={"joint2.scale": 0.4})
    began = np.array([*READY, 0.0, 0.0, 0.0])
    made.begin(np.arange(1), (began[None], np.zeros((1, 10))))
    for _ in range(25):
        made.step(np.array([[0.2] * 7 + [0.0]]))
    moved, lag = made.state[0][0] - began, 20.09 / 403.4  # s, kv / kp: that of the servo
    speeds = 0.2 * np.array([2.175] * 4 + [2.61] * 3) * [0.26, 0.4, *[0.26] * 5]
    np.testing.assert_allclose(moved[:7], speeds * (1.0 - lag), rtol=0.02)
    np.testing.assert_allclose(made.state[0][0, 7:9], 0.02, atol=1e-4)


def test_the_drawer_slides_against_its_damping_to_the_end_of_its_travel() -> None:
    compiled, data = machine()
    joint, mass, damping, force = compiled.joint("drawer"), 2.0, 7.389, 1.0
    compiled.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)  # the arm stays out of the way
    data.qfrc_applied[joint.dofadr] = force
    data.qpos[:7] = READY
    for _ in range(50):
        mujoco.mj_step(compiled, data)
    expected = force / damping * (1.0 - np.exp(-damping / mass * data.time))
    assert data.qvel[joint.dofadr[0]] == pytest.approx(expected, rel=0.02)
    for _ in range(400):
        mujoco.mj_step(compiled, data)
    assert data.qpos[joint.qposadr[0]] == pytest.approx(0.3, abs=1e-3)


def test_the_reward_is_the_weighted_sum_of_its_terms() -> None:
    made = episodes()
    qpos = made.state[0]
    qpos[0, 6] += 0.3  # the hand turns about its approach
    qpos[0, 9] = 0.03
    made.begin(np.arange(1), (qpos, np.zeros((1, 10))))
    action = np.array([[0.0] * 7 + [1.0]])
    reward = made.step(action).reward[0]
    pose = flange(qpos[0, :7])
    effector, handle = pose[:3, 3] + 0.1034 * pose[:3, 2], np.array([0.69, 0.0, 0.65])
    hand = pose[:3, :3] @ np.array([[1, 1, 0], [-1, 1, 0], [0, 0, np.sqrt(2)]]) / np.sqrt(2)  # −45° about the approach
    wanted = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]])
    angle = np.arccos((np.trace(wanted.T @ hand) - 1.0) / 2.0)
    away = np.abs(effector - handle)
    assert away[1] < 0.07
    fingers = 0.005 * (away[0] < 0.02)
    expected = -0.5 * np.linalg.norm(away) - 0.07 * angle - 0.4 * 0.27 + fingers - 0.005
    assert reward == pytest.approx(expected, abs=2e-4)  # places are one physics step old


def test_the_handle_is_seen_where_the_cabinet_stands() -> None:
    made = episodes("env/context=[drawer/cabinet]", context={"cabinet.lateral": 0.15})
    np.testing.assert_allclose(made.observation[0, 7:], [0.72, 0.15, 0.65], atol=1e-12)
    assert made.observation.shape == (1, 10)


def test_the_drawer_is_open_where_its_handle_has_come_far_enough() -> None:
    made = episodes(slots=2)
    qpos = made.state[0]
    qpos[:, 9] = [0.19, 0.21]
    made.begin(np.arange(2), (qpos, np.zeros((2, 10))))
    np.testing.assert_array_equal(made.task.solved(made.observation), [False, True])


def test_closing_fingers_hold_the_bar_by_its_friction() -> None:
    made = episodes("env/context=[drawer/drawer]", slots=2)
    space = made.space
    made.give_contexts(np.array([space.vector({"handle.friction": mu}) for mu in (1.0, 0.0)]))
    qpos = np.tile([*GRASPING, 0.04, 0.04, 0.0], (2, 1))
    made.begin(np.arange(2), (qpos, np.zeros((2, 10))))
    shut = [0.0] * 7 + [-1.0]
    for _ in range(10):
        made.step(np.tile(shut, (2, 1)))
    assert (made.state[0][:, 7:9].sum(axis=1) > 0.017).all()  # the bar, 20 mm thick, is between them
    for _ in range(40):
        made.step(np.tile([0.0, -0.77, 0.0, -0.82, 0.0, 0.03, 0.0, -1.0], (2, 1)))
    held, slipped = made.state[0][:, 9]
    assert held > 0.05
    assert slipped < 0.2 * held
