"""Pusher-3DOF: geometry, masses, reward, starts, and a puck that slides as its friction and damping say."""

import numpy as np
import pytest
from hydra.errors import InstantiationException
from settings import setting
from sliding import slid, sliding_distance

from dr_lab.envs.episodes import Episodes

PUCK = 0.5 * np.pi * 0.1**2 * 0.2  # kg
ARMATURE = 0.04  # kg
AWAY = np.array([0.0, 0.0, 0.0, 0.0, 2.0, 1.0, -1.0])  # the puck beyond the arm's reach


def episodes(slots: int = 2, seed: int = 0) -> Episodes:
    return setting("pusher_3dof").make(None, slots, seed, threads=1).episodes


def capsule(radius: float, length: float) -> float:
    return 300.0 * np.pi * (radius**2 * length + 4.0 / 3.0 * radius**3)


def test_the_wrist_lies_where_the_chain_ends() -> None:
    one = episodes()
    qpos = np.tile(AWAY, (2, 1))
    qpos[:, :3] = np.random.default_rng(0).uniform(-1.0, 1.0, (2, 3))
    one.begin(np.arange(2), (qpos, np.zeros((2, 7))))
    headings = np.cumsum(qpos[:, :3] + [0.785, -0.785, -1.57], axis=1)
    wrist = 0.4 * np.stack([np.cos(headings).sum(1), np.sin(headings).sum(1)], axis=1)
    expected = np.concatenate([qpos[:, :3], np.zeros((2, 3)), wrist, qpos[:, 3:]], axis=1)
    np.testing.assert_allclose(one.observation, expected, atol=1e-12)


def test_it_weighs_what_its_shapes_do() -> None:
    compiled = setting("pusher_3dof").model.nominal()
    tips = 2 * 300.0 * 4.0 / 3.0 * np.pi * 0.01**3
    fork = capsule(0.04, 0.4) + 2 * capsule(0.04, 0.2) + tips
    expected = [0.0, *[capsule(0.06, 0.4)] * 3, fork, PUCK, 0.001]
    np.testing.assert_allclose(compiled.body_mass, expected, rtol=1e-9)


def test_the_reward_is_that_of_the_state_before_the_step() -> None:
    one = episodes()
    start = np.array([[0.0, 0.0, 0.0, 0.5, 2.0, 0.8, 1.6], AWAY])
    velocity = np.zeros((2, 7))
    velocity[0, 3:5] = 1.0  # by which the puck has moved after the step
    one.begin(np.arange(2), (start, velocity))
    reward = one.step(np.array([[0.5, -1.0, 0.0], [9.0, 9.0, -9.0]])).reward
    np.testing.assert_allclose(reward, [-0.5 - 0.1 * 1.25, -np.hypot(1.0, 3.0) - 0.1 * 3.0])  # 9 N·m are cut off at 1


def test_the_puck_slides_as_its_friction_and_damping_say() -> None:
    one, z = episodes(3), np.array([[0.01, 0.025], [0.00666, 0.01665], [0.0005, 0.00125]])
    one.give_contexts(z)
    one.begin(np.arange(3))
    for column in (3, 4):
        found = slid(one, AWAY, column, 0.3, 600)
        expected = [sliding_distance(PUCK + ARMATURE, friction, damping, 0.3) for friction, damping in z]
        np.testing.assert_allclose(found, expected, rtol=0.02)


def test_the_fork_takes_the_puck_along_and_joints_stop_at_their_limits() -> None:
    one = episodes()
    start = np.array([0.0, 0.0, 0.0, 0.69, -0.4, 1.0, -1.0])
    one.begin(np.arange(2), (np.tile(start, (2, 1)), np.zeros((2, 7))))
    for _ in range(60):
        one.step(np.array([[-1.0, 0.0, 0.0], [0.0, -1.0, 1.0]]))
    qpos, _ = one.state
    assert qpos[0, 4] < -0.6
    assert (np.abs(qpos[:, :3]) < [2.5 + 0.05, 2.3213 + 0.05, 2.3213 + 0.05]).all()
    assert qpos[1, 2] == pytest.approx(2.3, abs=0.05)


def test_starts_are_apart_and_within_their_ranges() -> None:
    qpos, qvel = episodes(400).state
    assert (np.abs(qpos[:, :3]) <= 0.1).all()
    for places, low, high in ((qpos[:, 3:5], [0.4, -1.0], [1.2, -0.5]), (qpos[:, 5:], [0.8, -1.2], [1.2, -0.8])):
        assert ((places >= low) & (places <= high)).all()
    assert (np.linalg.norm(qpos[:, 3:5] - qpos[:, 5:], axis=1) > 0.45).all()
    assert not qvel.any()
    np.testing.assert_array_equal(episodes(3).state[0], qpos[:3])  # each slot has a stream of its own


def test_places_that_are_never_apart_are_refused() -> None:
    with pytest.raises(InstantiationException, match=r"env\.task\.apart is 2 m; expected less than 1\.06301 m"):
        setting("pusher_3dof", "env.task.apart=2.0")
