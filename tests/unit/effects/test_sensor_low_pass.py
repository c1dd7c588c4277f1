import numpy as np
import pytest
from effect_machines import CONF, block, placed
from hydra.utils import instantiate
from omegaconf import OmegaConf

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
    assert reach(transform) == pytest.approx((2 + np.sqrt(2)) * 0.0058)
    assert reach(transform) < windows.margin
