"""What instruments do to a clean signal: four kinds of noise of the same standard deviation."""

from collections.abc import Callable, Mapping

import numpy as np
from scipy.signal import butter, lfilter, sosfilt

from dr_lab.trajectory import Array

CORRELATION = 0.020  # s, of coloured noise: what a bus that averages, or a tracker that smooths, leaves
CUTOFF = 20.0  # Hz, of low-passed noise: a usual filter of a servo drive
_ORDER = 2  # of that filter
_SETTLED = 0.5  # s of noise before the first sample, in which the filter forgets its start


def white(clean: Array, step: float, std: float, rng: np.random.Generator) -> Array:
    """Independent normal errors; `clean` has shape (n,), `step` is s between samples, `std` in its unit."""
    del step
    return clean + std * rng.normal(size=len(clean))


def coloured(clean: Array, step: float, std: float, rng: np.random.Generator) -> Array:
    """Errors with correlation exp(−|t|/τ), τ = `CORRELATION`: e_k = φ e_{k−1} + √(1 − φ²) σ w_k, φ = exp(−step/τ)."""
    kept = np.exp(-step / CORRELATION)
    drive = std * rng.normal(size=len(clean)) * np.where(np.arange(len(clean)) > 0, np.sqrt(1 - kept**2), 1.0)
    return clean + np.asarray(lfilter([1.0], [1.0, -kept], drive), np.float64)


def low_passed(clean: Array, step: float, std: float, rng: np.random.Generator) -> Array:
    """White errors behind a Butterworth filter of order 2 at `CUTOFF`, scaled to `std`; the signal is not filtered."""
    before = round(_SETTLED / step)
    sections = butter(_ORDER, CUTOFF, fs=1 / step, output="sos")
    impulse = np.zeros(before)
    impulse[0] = 1.0
    gain = np.linalg.norm(sosfilt(sections, impulse))  # standard deviation of what unit white noise becomes
    noise = np.asarray(sosfilt(sections, rng.normal(size=before + len(clean))), np.float64)
    return clean + std / gain * noise[before:]


def quantised(clean: Array, step: float, std: float, rng: np.random.Generator) -> Array:
    """Rounding to q = √12 σ, whose error has the standard deviation σ where the signal moves by more than q.

    Source: Widrow and Kollár, Quantization Noise, 2008, §4.
    """
    del step, rng
    quantum = np.sqrt(12.0) * std
    return quantum * np.round(clean / quantum)


NOISES: Mapping[str, Callable[[Array, float, float, np.random.Generator], Array]] = {
    "white": white,
    "coloured": coloured,
    "low_passed": low_passed,
    "quantised": quantised,
}
