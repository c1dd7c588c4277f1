"""ErgoReacher: geometry, masses, reward, starts, and servos whose torque and speed end where the context says."""

import numpy as np
import pytest
from hydra.errors import InstantiationException
from settings import setting

from dr_lab.envs.episodes import Episodes
from dr_lab.trajectory import Array

# frame by frame from the base to the tip, m; letters are the turning joints
CHAIN: tuple[tuple[float, float] | int, ...] = (
    *((0.038, 0.005), (-0.010, 0.003), (0.0095, 0.027), (0.0, 0.024)),
    *(0, (0.0, 0.019), (0.0, 0.035)),
    *(1, (0.0, 0.026), (0.0, 0.002), (0.013, 0.015), (0.035, 0.0)),
    *(2, (0.019, 0.0), (0.035, 0.0)),
    *(3, (0.030, 0.0)),
)
FAR = [0.1, 0.5]  # a goal out of the way


def episodes(slots: int = 2, **context: float) -> Episodes:
    of = setting("ergo_reacher")
    made = of.make(None, slots, 0, threads=1).episodes
    made.give_contexts(np.tile(of.space.vector(context), (slots, 1)))
    made.begin(np.arange(slots))
    return made


def tip(angles: Array) -> Array:
    """Its y and z: every joint leans what follows it forwards and down."""
    place, lean = np.zeros(2), 0.0
    for part in CHAIN:
        if isinstance(part, int):
            lean += angles[part]
        else:
            y, z = part
            place += [y * np.cos(lean) + z * np.sin(lean), z * np.cos(lean) - y * np.sin(lean)]
    return place


def begun_at(made: Episodes, angles: Array, goal: Array) -> None:
    count = made.nsim
    qpos = np.concatenate([np.broadcast_to(angles, (count, 4)), np.broadcast_to(goal, (count, 2))], axis=1)
    made.begin(np.arange(count), (qpos, np.zeros((count, 6))))


def test_the_tip_lies_where_the_chain_ends() -> None:
    made, angles = episodes(3), np.random.default_rng(0).uniform(-0.7, 0.7, (3, 4))
    begun_at(made, angles, np.array(FAR))
    places = made.simulator.batch.bind("site_xpos")[:, 0]
    np.testing.assert_allclose(places[:, 1:], [tip(row) for row in angles], atol=1e-9)
    np.testing.assert_allclose(places[:, 0], 0.0, atol=1e-9)


def test_it_weighs_what_is_documented() -> None:
    compiled = setting("ergo_reacher").model.nominal()
    masses = {compiled.body(i).name: compiled.body_mass[i] for i in range(1, compiled.nbody)}
    motors = {f"motor_{i}": 0.1 for i in range(1, 7)}
    links = {"base": 0.038, "static": 0.011, "link_1": 0.005, "bridge_4": 0.001, "penholder": 0.004, "goal": 0.001}
    assert masses == pytest.approx(motors | links | {"bridge_3": 0.0045, "bridge_5": 0.0045, "bridge_6": 0.0045})


def test_the_reward_is_of_the_distance_in_space() -> None:
    made, angles = episodes(3), np.array([0.3, 0.2, -0.1, 0.4])
    begun_at(made, angles, tip(angles) + np.array([[0.003, -0.004], [0.03, 0.04], [-0.3, 0.0]]))
    rewards = made.step(np.tile(angles, (3, 1))).reward
    np.testing.assert_allclose(rewards, [1.0, -0.05, -0.3], atol=1e-3)  # it sinks a little


def test_angles_speeds_and_goal_are_seen_in_their_units() -> None:
    made = episodes(1)
    qpos, qvel = np.array([[0.1, -0.2, 0.3, -0.4, 0.0369 + 0.2022, 0.0437 + 0.261]]), np.zeros((1, 6))
    qvel[0, :4] = [1.8, -1.8, 9.0, 18.0]
    made.begin(np.arange(1), (qpos, qvel))
    seen = [*(qpos[0, :4] / (np.pi / 2)), 0.1, -0.1, 0.5, 1.0, 1.0, 1.0]
    np.testing.assert_allclose(made.observation[0], seen, atol=1e-6)


def test_a_servo_turns_at_most_at_its_speed() -> None:
    made = episodes(1, **{"motor_6.speed": 5.0})
    begun_at(made, np.array([0.0, 0.0, 0.0, -1.0]), np.array(FAR))
    courses = []
    for _ in range(20):
        made.step(np.array([[0.0, 0.0, 0.0, 1.0]]))
        qpos, qvel = made.state
        courses.append((qpos[0, 3], qvel[0, 3]))
    places, speeds = np.array(courses).T
    assert speeds.max() == pytest.approx(5.0, rel=0.05)
    assert places[19] - places[9] == pytest.approx(0.5, rel=0.05)  # 5 rad/s for 0.1 s


def test_a_servo_gives_at_most_its_torque() -> None:
    made = episodes(2, **{"motor_2.torque": 0.3})
    force = made.simulator.batch.bind("actuator_force")
    begun_at(made, np.zeros(4), np.array(FAR))
    for _ in range(5):
        made.step(np.array([[1.5, 1.5, 0.0, 0.0], [-1.5, -1.5, 0.0, 0.0]]))
        assert (np.abs(force) <= [0.3 + 1e-9, 1.0 + 1e-9, 1.0 + 1e-9, 1.0 + 1e-9]).all()
    assert np.abs(force[:, 0]).max() == pytest.approx(0.3)


def test_a_weak_robot_falls_and_cannot_lift_itself_but_the_nominal_one_can() -> None:
    leaning, upright, heights = np.array([0.8, 0.0, -0.5, 0.0]), np.zeros((1, 4)), []
    for torque in (1.0, 0.2):
        made = episodes(1, **{f"motor_{i}.torque": torque for i in (2, 3, 5, 6)})
        begun_at(made, leaning, np.array(FAR))
        for command in [leaning[None]] * 50 + [upright] * 50:
            made.step(command)
            heights.append(made.simulator.batch.bind("site_xpos")[0, 0, 2])
    nominal, weak = np.array(heights).reshape(2, 100)
    assert nominal[49] == pytest.approx(tip(leaning)[1], abs=0.01)  # the droop of a finite gain
    assert nominal[99] == pytest.approx(tip(upright[0])[1], abs=0.01)
    assert (weak[[49, 99]] < 0.02).all()  # it lies on the floor


def test_it_does_not_fold_into_its_case() -> None:
    made = episodes(1)
    begun_at(made, np.zeros(4), np.array(FAR))
    for _ in range(100):
        made.step(np.full((1, 4), -np.pi / 2))
        qpos, _ = made.state
        assert qpos[0, 0] + qpos[0, 1] > -np.pi / 2 - 0.05
        assert (np.abs(qpos[0, :4]) < np.pi / 2 + 0.05).all()


def test_goals_lie_in_the_half_disc_and_stay_there() -> None:
    made = episodes(500)
    qpos, qvel = made.state
    assert (np.abs(qpos[:, :4]) <= 0.2 * np.pi / 2).all()
    assert not qvel.any()
    goal = qpos[:, 4:] - [0.0369, 0.0437]
    far = np.linalg.norm(goal, axis=1)
    assert ((far >= 0.1) & (far <= 0.2022) & (goal[:, 1] >= 0.0) & (goal[:, 0] >= -0.1348)).all()
    behind = goal[:, 0] < 0.0
    assert 0.1 < behind.mean() < 0.4
    assert (goal[behind, 1] > 0.1305).all()
    made.step(np.zeros((500, 4)))
    np.testing.assert_allclose(made.state[0][:, 4:], qpos[:, 4:], atol=1e-9)
    np.testing.assert_array_equal(episodes(3).state[0], qpos[:3])  # each slot has a stream of its own


def test_radii_in_the_wrong_order_are_refused() -> None:
    with pytest.raises(InstantiationException, match=r"env\.task\.goal_radius is \[0\.3, 0\.2\]; expected"):
        setting("ergo_reacher", "env.task.goal_radius=[0.3,0.2]")
