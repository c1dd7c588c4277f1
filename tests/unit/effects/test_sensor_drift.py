import numpy as np
from effect_machines import block, placed

from dr_lab.trajectory import Array

BEGIN = np.array([[0.0], [1.5], [4.0]])  # three windows
RATE = np.array([[0.01], [0.0]])


def still(time: Array) -> Array:
    return np.full((*time.shape, 1), 0.3)


def test_position_moves_with_the_clock_of_the_log_and_velocity_by_its_rate() -> None:
    model, time = block().with_effect(placed(block(), "sensor_drift", "rail")), np.array([[[0.0, 0.2]] * 3])
    seen = model.reading(RATE, "rail.position", still, BEGIN)(time)
    expected = [[[0.3, 0.302], [0.315, 0.317], [0.34, 0.342]], np.full((3, 2), 0.3)]
    np.testing.assert_allclose(seen[..., 0], expected, rtol=1e-12)
    speed = model.reading(RATE, "rail.velocity", still, BEGIN)(time)
    np.testing.assert_allclose(speed[..., 0], [np.full((3, 2), 0.31), np.full((3, 2), 0.3)], rtol=1e-12)
    assert model.reading(RATE, "other.position", still, BEGIN) is still


def test_bounds_follow_the_range_of_motion() -> None:
    (parameter,) = placed(block(), "sensor_drift", "rail").parameters
    assert (parameter.low, parameter.high, parameter.unit) == (-0.02, 0.02, "m/s")
