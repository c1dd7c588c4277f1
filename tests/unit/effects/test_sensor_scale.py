import numpy as np
from effect_machines import block, placed

from dr_lab.trajectory import Array

START = np.zeros((1, 1))
EXCESS = np.array([[0.1], [0.0], [-0.2]])


def wave(time: Array) -> Array:
    return np.sin(7.0 * time)[..., None]


def test_position_and_velocity_are_scaled_about_zero() -> None:
    model, time = block().with_effect(placed(block(), "sensor_scale", "rail")), np.linspace(0.1, 0.2, 5)[None, None]
    for channel in ("rail.position", "rail.velocity"):
        seen = model.reading(EXCESS, channel, wave, START)(time)
        np.testing.assert_allclose(seen[:, 0, :, 0], (1 + EXCESS) * np.sin(7.0 * time[0]))
    assert model.reading(EXCESS, "other.position", wave, START) is wave


def test_bounds_are_symmetric() -> None:
    (parameter,) = placed(block(), "sensor_scale", "rail").parameters
    assert (parameter.low, parameter.nominal, parameter.high) == (-0.2, 0.0, 0.2)
