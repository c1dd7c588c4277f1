import numpy as np
import pytest

from dr_lab.diagnosis.windows.invert_reading import Transform, reach, unread
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array

REPORTED = np.array([[0.4, -1.0], [3.0, 0.5], [-20.0, 7.0]])  # two windows


def delayed(read: Reading) -> Reading:
    late = np.array([0.0, 0.004, -0.01])[:, None, None]
    return lambda time: read(time - late)


def scaled(read: Reading) -> Reading:
    return lambda time: 1.02 * read(time) + 0.03


def wavy(read: Reading) -> Reading:
    """An encoder off its centre."""
    return lambda time: read(time) + 0.01 * np.sin(read(time))


def untouched(read: Reading) -> Reading:
    return read


def test_a_late_reading_starts_later() -> None:
    position, velocity = unread(REPORTED, delayed)
    _, v, a = REPORTED
    for row, late in enumerate([0.0, 0.004, -0.01]):
        np.testing.assert_allclose(position[row], v * late + a * late**2 / 2, atol=1e-12)
        np.testing.assert_allclose(velocity[row], a * late, atol=1e-10)
    assert reach(delayed) == pytest.approx(0.01)


@pytest.mark.parametrize("transform", [scaled, wavy])
def test_the_motion_reads_as_was_reported(transform: Transform) -> None:
    position, velocity = unread(REPORTED, transform)

    def motion(time: Array) -> Array:
        q, v, a = REPORTED
        return ((q + position[0])[:, None] + time * ((v + velocity[0])[:, None] + 0.5 * time * a[:, None]))[..., None]

    step = 1e-4
    before, now, after = (transform(read=motion)(np.full((1, 1, 1), t))[0, :, 0, 0] for t in (-step, 0.0, step))
    np.testing.assert_allclose(now, REPORTED[0], atol=1e-5)
    np.testing.assert_allclose((after - before) / (2 * step), REPORTED[1], atol=1e-2)


def test_sensors_without_effect_change_nothing() -> None:
    assert not np.any(unread(REPORTED, untouched))
    assert reach(untouched) == 0.0
