"""ErgoPusher: geometry, masses, reward, starts, and a puck that slides as its friction and damping say."""

import numpy as np
import pytest
from settings import setting
from sliding import slid, sliding_distance

from dr_lab.envs.episodes import Episodes

REST = np.array([-0.5, 1.0, 0.5]) * np.pi / 2
AWAY = np.array([*REST, 0.5, -0.5, -0.15, 0.0])  # the puck, y before x, beyond the arm's reach


def episodes(slots: int = 2) -> Episodes:
    return setting("ergo_pusher").make(None, slots, 0, threads=1).episodes


def test_the_fork_lies_where_the_chain_ends() -> None:
    made = episodes()
    places = made.simulator.batch.bind("site_xpos")
    qpos = np.tile(AWAY, (2, 1))
    qpos[1, :3] = [0.3, 0.4, -0.7]
    made.begin(np.arange(2), (qpos, np.zeros((2, 7))))
    headings, lengths = np.cumsum(qpos[:, :3], axis=1), np.array([0.054, 0.054, 0.027])
    expected = np.stack([-np.sin(headings) @ lengths, np.cos(headings) @ lengths, [0.01, 0.01]], axis=1)
    np.testing.assert_allclose(places[:, 0], expected, atol=1e-12)


def test_it_weighs_what_is_documented() -> None:
    compiled = setting("ergo_pusher").model.nominal()
    masses = {compiled.body(i).name: compiled.body_mass[i] for i in range(1, compiled.nbody)}
    motors, links = {f"motor_{i}": 0.1 for i in range(1, 4)}, {"bridge_2": 0.0045, "bridge_3": 0.0045, "fork": 0.004}
    assert masses == pytest.approx(motors | links | {"carriage": 0.1, "puck": 0.1, "goal": 0.001})


def test_the_reward_is_of_the_puck_and_places_are_seen_as_shares_of_their_ranges() -> None:
    made = episodes()
    straight = np.zeros(3)  # out of the puck's way
    qpos = np.array([[*straight, 0.05, -0.07, -0.2, -0.1], [*straight, 0.08, -0.1, -0.1, 0.075]])
    made.begin(np.arange(2), (qpos, np.zeros((2, 7))))
    np.testing.assert_allclose(made.observation[:, 6:], [[0.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 175 / 150]], atol=1e-6)
    rewards = made.step(np.zeros((2, 3))).reward
    np.testing.assert_allclose(rewards, [-np.hypot(0.13, 0.15), 1.0], atol=1e-6)


def test_the_puck_slides_as_its_friction_and_damping_say() -> None:
    made, z = episodes(3), np.array([[0.4, 0.1], [0.268, 0.067], [0.2, 0.05]])
    made.give_contexts(z)
    made.begin(np.arange(3))
    for column, mass in ((3, 0.2), (4, 0.1)):  # along y both slides move
        found = slid(made, AWAY, column, -0.3, 40)
        expected = [-sliding_distance(mass, friction, damping, 0.3) for friction, damping in z]
        np.testing.assert_allclose(found, expected, rtol=0.03)


def test_the_fork_pushes_the_puck() -> None:
    made = episodes(1)
    start = np.array([*REST, 0.076, -0.06, -0.15, 0.0])
    made.begin(np.arange(1), (start[None], np.zeros((1, 7))))
    for _ in range(40):
        made.step(np.array([[0.2, 1.2, 0.3]]))
    qpos, _ = made.state
    assert np.linalg.norm(qpos[0, 3:5] - start[3:5]) > 0.03
    assert (np.abs(qpos[0, :3]) < np.pi / 2 + 0.05).all()


def test_starts_are_within_their_ranges() -> None:
    qpos, qvel = episodes(300).state
    assert (np.abs(qpos[:, :3] - REST) <= 0.1 * np.pi / 2 + 1e-9).all()
    assert (qpos[:, 1] <= np.pi / 2 + 1e-9).all()
    puck, goal = qpos[:, [4, 3]], qpos[:, 5:]
    for places, low, high in ((puck, [-0.1, 0.05], [-0.07, 0.08]), (goal, [-0.2, -0.1], [-0.1, 0.05])):
        assert ((places >= low) & (places <= high)).all()
    assert not qvel.any()
    np.testing.assert_array_equal(episodes(3).state[0], qpos[:3])  # each slot has a stream of its own
