import numpy as np
from effect_machines import block, placed

from dr_lab.physics.simulator import Simulator

WIDTHS = np.array([[0.0], [1.0], [2.5]])


def test_commands_lose_the_width_and_never_change_sign() -> None:
    model = block().with_effect(placed(block(), "dead_zone", "drive"))
    series = np.array([[[-3.0, -1.0, -0.2, 0.0, 0.2, 2.0, 5.0]]])
    expected = [[-3, -1, -0.2, 0, 0.2, 2, 5], [-2, 0, 0, 0, 0, 1, 4], [-0.5, 0, 0, 0, 0, 0, 2.5]]
    np.testing.assert_allclose(model.command(WIDTHS, "drive", series)[:, 0], expected)
    assert model.command(WIDTHS, "another", series) is series


def test_the_machine_feels_what_is_left() -> None:
    model = block().with_effect(placed(block(), "dead_zone", "drive"))
    controls = np.full((1, 50, 1), -3.0)
    rollout = Simulator(model, 3, threads=1).replay(
        WIDTHS, np.zeros((3, 1, 1)), np.zeros((3, 1, 1)), controls, np.zeros((1, 30, 1))
    )
    np.testing.assert_allclose(rollout.qvel[:, -1, 0], [-0.15, -0.1, -0.025])  # (3 − d) N / 2 kg · 0.1 s


def test_a_delayed_actuator_remembers_what_was_left() -> None:
    """3 N lose 2 N, also those of before the start that act late."""
    model = block().with_effect(placed(block(), "dead_zone", "drive"))
    model = model.with_effect(placed(block(), "actuator_delay", "drive"))
    start = np.zeros((1, 1, 1))
    held, before = np.full((1, 50, 1), 3.0), np.full((1, 30, 1), 3.0)
    rollout = Simulator(model, 1, threads=1).replay(np.array([[2.0, 0.02]]), start, start, held, before)
    np.testing.assert_allclose(rollout.qvel[0, -1, 0], 0.05)  # 1 N / 2 kg · 0.1 s


def test_bounds_follow_the_commands() -> None:
    (parameter,) = placed(block(), "dead_zone", "drive").parameters
    assert (parameter.low, parameter.high) == (0.0, 2.5)
