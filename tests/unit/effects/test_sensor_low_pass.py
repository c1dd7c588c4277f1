from dataclasses import replace

import numpy as np
import pytest
from diagnosis_machines import pendulum, swinging, windows_of
from effect_machines import CONF, block, placed
from hydra.utils import instantiate
from omegaconf import OmegaConf

from dr_lab.diagnosis.search.wider import widened
from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.invert_reading import reach
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array

START = np.zeros((1, 1))
TAUS = np.array([[0.0], [0.002], [0.0058]])
TIME = np.linspace(0.1, 0.2, 7)[None, None]


def cubic(time: Array) -> Array:
    return (0.3 + time * (2.0 + time * (-50.0 + 400.0 * time)))[..., None]


def sine(time: Array) -> Array:
    return np.sin(40.0 * time)[..., None]


def seen(read: Reading, channel: str) -> Array:
    model = block().with_effect(placed(block(), "sensor_low_pass", "rail"))
    return model.reading(TAUS, channel, read, START)(TIME)[:, 0, :, 0]


@pytest.mark.parametrize("channel", ["rail.position", "rail.velocity"])
def test_cubic_motion_is_filtered_exactly(channel: str) -> None:
    """tau y' + y = q has the particular solution q − tau q' + tau² q'' − tau³ q'''."""
    t, tau = TIME[0], TAUS
    slopes = [2.0 - 100.0 * t + 1200.0 * t**2, -100.0 + 2400.0 * t, 2400.0]
    exact = cubic(TIME)[0, :, :, 0] - tau * slopes[0] + tau**2 * slopes[1] - tau**3 * slopes[2]
    np.testing.assert_allclose(seen(cubic, channel), exact, rtol=1e-12)


def test_sine_is_weakened_and_late() -> None:
    exact = np.imag(np.exp(40.0j * TIME[0]) / (1 + 40.0j * TAUS))
    assert (np.abs(seen(sine, "rail.position") - exact) <= (40.0 * TAUS) ** 4 + 1e-12).all()


def test_other_channels_are_left_alone() -> None:
    model = block().with_effect(placed(block(), "sensor_low_pass", "rail"))
    assert model.reading(TAUS, "other.position", sine, START) is sine


def test_looks_back_no_farther_than_the_windows_keep() -> None:
    model = block().with_effect(placed(block(), "sensor_low_pass", "rail"))
    bounds = np.stack([model.space.low, model.space.high])

    def transform(read: Reading) -> Reading:
        return model.reading(bounds, "rail.position", read, START)

    windows = instantiate(OmegaConf.load(CONF / "comparison" / "default.yaml").windows)
    assert isinstance(windows, WindowSettings)
    assert windows.margin >= reach(transform) == pytest.approx(windows.margin, rel=1e-3)


def test_its_bound_is_moved_as_far_as_the_windows_keep() -> None:
    one, windows = (
        placed(pendulum(), "sensor_low_pass", "hinge"),
        windows_of(pendulum(), [swinging("a", pendulum().nominal(), 0)]),
    )
    (tau,) = one.parameters
    assert widened(one, np.array([tau.high]), windows) is None
    wide = widened(one, np.array([tau.high]), replace(windows, margin=0.03))
    assert wide is not None
    (farther,) = wide.parameters
    assert farther.high == pytest.approx(0.03 / (2 + np.sqrt(2)))
    model = pendulum().with_effect(wide)
    assert reach(lambda *, read: model.reading(model.space.high[None], "hinge.position", read, START)) <= 0.03 + 1e-12
