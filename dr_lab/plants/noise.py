"""Noise of encoders: white, or of a colour that a filter gives it."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.signal import butter, lfilter, sosfilt

from dr_lab.bounds import NotNegative, Positive
from dr_lab.errors import ConfigError
from dr_lab.trajectory import Array


class Noise(Protocol):
    """Stationary noise on evenly spaced samples, zero on average."""

    def draw(self, count: int, rate: float, generator: np.random.Generator) -> Array:
        """One stretch of noise in rad, shape (count,), at samples of a rate in Hz."""
        ...

    def white_equal(self, rate: float) -> float:
        """Standard deviation in rad of white noise with the same density at low frequencies, at a sample rate in Hz.

        What is slow against the noise's colour is hidden by it as much as by this white noise.
        """
        ...


@dataclass(frozen=True)
class WhiteNoise:
    """Gaussian and independent from sample to sample.

    Attributes:
        std: rad.
    """

    std: NotNegative

    def draw(self, count: int, rate: float, generator: np.random.Generator) -> Array:
        """Independent samples."""
        del rate
        return self.std * generator.standard_normal(count)

    def white_equal(self, rate: float) -> float:
        """Its own."""
        del rate
        return self.std


@dataclass(frozen=True)
class CorrelatedNoise:
    """Gaussian, correlated over a time: n_k = a n_{k−1} + std √(1 − a²) w_k, a = exp(−1 / (rate · time)).

    Attributes:
        std: rad.
        time: s, after which the correlation has fallen to 1/e.
    """

    std: NotNegative
    time: Positive

    def draw(self, count: int, rate: float, generator: np.random.Generator) -> Array:
        """An Ornstein–Uhlenbeck process that is stationary from the first sample on."""
        kept = self._kept(rate)
        shocks = generator.standard_normal(count)
        shocks[1:] *= np.sqrt(1 - kept**2)
        return self.std * np.asarray(lfilter([1.0], [1.0, -kept], shocks))

    def white_equal(self, rate: float) -> float:
        """As std √((1 + a) / (1 − a))."""
        kept = self._kept(rate)
        return float(self.std * np.sqrt((1 + kept) / (1 - kept)))

    def _kept(self, rate: float) -> float:
        return float(np.exp(-1.0 / (rate * self.time)))


@dataclass(frozen=True)
class LowPassedNoise:
    """White noise through a Butterworth filter of second order: nothing is left far above the corner.

    Attributes:
        std: rad, after the filter.
        corner: Hz, below half of the sample rate.

    Raises:
        ConfigError: it is not, at the rate at which noise is drawn.
    """

    std: NotNegative
    corner: Positive

    def draw(self, count: int, rate: float, generator: np.random.Generator) -> Array:
        """Filtered noise, its first samples, in which the filter settles, cut off."""
        settling = int(np.ceil(3 * rate / self.corner))
        filtered = sosfilt(self._filter(rate), generator.standard_normal(settling + count))
        return np.asarray(self.white_equal(rate) * np.asarray(filtered)[settling:])

    def white_equal(self, rate: float) -> float:
        """As std / √(Σ h²): the filter passes low frequencies as they are."""
        count = int(np.ceil(20 * rate / self.corner))
        response = np.asarray(sosfilt(self._filter(rate), np.eye(1, count)[0]))
        return float(self.std / np.sqrt(response @ response))

    def _filter(self, rate: float) -> Array:
        if self.corner >= rate / 2:
            raise ConfigError(
                f"The noise has its corner at {self.corner:g} Hz; expected less than half of the sample rate, which is "
                f"{rate:g} Hz. Lower the instruments' noise.corner, or raise their sample_rate."
            )
        return np.asarray(butter(2, self.corner, fs=rate, output="sos"))
