import numpy as np
import pytest
from effect_machines import block, hanging, motion, placed, with_effect

from dr_lab.diagnosis.windows.invert_reading import unread
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


def test_its_bound_is_moved_as_far_as_windows_starts_are_found() -> None:
    """A reading (1 + s) q is undone by rounds that leave s⁹ of it."""
    excess = placed(block(), "sensor_scale", "rail").effect.limit("excess", kept=0.3, margin=0.02)
    assert excess == 0.5
    reported = np.array([[1.0 + excess], [0.0], [0.0]])
    found, _ = unread(reported, lambda *, read: lambda time: (1.0 + excess) * read(time))
    assert reported[0, 0] + found[0, 0] == pytest.approx(1.0, abs=2e-3)


def test_another_gear_ratio_is_a_torque_and_a_reading_of_another_size() -> None:
    """A motor behind a gear of 1.1 times the documented ratio, whose encoder sits at the motor."""
    ratio = 1.1
    geared = hanging()
    geared.spec.actuator("drive").gear[0] *= ratio
    time, joint, _ = motion(geared.nominal(), 1.0, qpos=0.4, ctrl=0.3).T
    scaled = motion(with_effect(hanging(), "torque_scale", "drive", factor=ratio), 1.0, qpos=0.4, ctrl=0.3)
    np.testing.assert_allclose(scaled[:, 1], joint, atol=1e-12)
    reads = hanging().with_effect(placed(hanging(), "sensor_scale", "hinge"))

    def read(at: Array) -> Array:
        return np.interp(at, time, joint)[..., None]

    seen = reads.reading(np.array([[ratio - 1]]), "hinge.position", read, START)(time[None, None])[0, 0, :, 0]
    np.testing.assert_allclose(seen, ratio * joint, atol=1e-12)
