"""The colour of residuals above the noise floor: whether a force or the instruments made them."""

import functools

import numpy as np
from numpy.polynomial.legendre import legvander
from numpy.typing import NDArray
from scipy.special import polygamma
from scipy.stats import chi2

from dr_lab.diagnosis.fit.correlation import autocorrelation, variance_time
from dr_lab.trajectory import Array

Mask = NDArray[np.bool_]
_TERMS = 4  # polynomials that fitted starts take out of a window: position and velocity of two joints
_DRAWS = 400  # references that a 99.9 % quantile is read from
_CHANCE = 1e-5  # that stationary noise is taken for something else
_FEWEST = 16  # samples in a window whose spectrum says anything
_WINDOWS = 8  # of which the scatter says anything


def instrumental(residual: Array, used: Mask, integrals: int) -> bool:
    """Whether residuals above the noise floor are the instruments' own, and not what a force left.

    1. Beyond the sensors' white noise they are rougher than a force makes them: however rough it is, as white noise, it
       moves a velocity by its integral and a position by its double integral. The mean frequency of the residuals'
       power is compared with that of integrated white noise in as many windows of the same length, less a polynomial
       of degree 3: more than what fitted starts take out of a window. White noise lies beside that reference in the
       same proportion as beside the residuals, for over few windows its scatter looks rough, too. It is as large as the
       upper half of the frequencies shows, at most as it is known: where noise is correlated, less of it is white.
    2. They are as large in every window as chance allows, whatever the machine does: ln χ² of a window, n samples of a
       stationary Gaussian process, has the variance ψ'(n_eff/2).

    Args:
        residual: residuals of w windows, in standard deviations of the sensors' white noise, shape (w, m).
        used: which of them exist, shape (w, m).
        integrals: 2 for a position, 1 for a velocity.
    """
    kept = residual[:, used.all(0)]
    windows, samples = len(kept), kept.shape[1]
    if windows < _WINDOWS or samples < _FEWEST or not (kept**2).sum(1).all():
        return False
    excess = float((kept**2).mean()) - 1.0
    if excess <= 0 or not _homogeneous(kept):
        return False
    power = (np.abs(_transform(kept)) ** 2).mean(0)
    white = float(_white(power, samples))
    return bool(_mean_frequency(power, samples) > _roughest(windows, samples, integrals, excess + 1.0 - white, white))


def _homogeneous(residual: Array) -> bool:
    windows, samples = residual.shape
    freedom = samples / variance_time(autocorrelation(residual, np.ones(residual.shape, bool)))
    scatter = np.var(np.log((residual**2).mean(1)), ddof=1) / float(polygamma(1, freedom / 2))
    return bool(scatter * (windows - 1) <= chi2.isf(_CHANCE, windows - 1))


def _roughest(windows: int, samples: int, integrals: int, excess: float, white: float) -> float:
    """Mean frequency that integrated noise of a variance, beside white noise, exceeds once in a thousand times."""
    force, beside, alone = _references(windows, samples, integrals)
    found = _mean_frequency(excess * force + np.sqrt(excess * white) * beside + white * alone, samples)
    return float(np.mean(found) + 3.1 * np.std(found))  # of a mean over windows, so that it is Gaussian


@functools.lru_cache(maxsize=8)
def _references(windows: int, samples: int, integrals: int) -> tuple[Array, Array, Array]:
    """Spectra of integrated noise of variance 1, of its product with white noise, and of that: each (draws, f)."""
    rng = np.random.default_rng(0)
    found = []
    for _ in range(_DRAWS):
        drawn = rng.standard_normal((windows, samples))
        for _ in range(integrals):
            drawn = np.cumsum(drawn, axis=1)
        drawn = _detrended(drawn)
        force, white = (_transform(each) for each in (drawn, rng.standard_normal((windows, samples))))
        force /= np.sqrt((drawn**2).mean())
        found.append(
            [(np.abs(force) ** 2).mean(0), 2 * (force * white.conj()).real.mean(0), (np.abs(white) ** 2).mean(0)]
        )
    first, second, third = np.moveaxis(np.array(found), 1, 0)
    return first, second, third


def _transform(signal: Array) -> NDArray[np.complex128]:
    return np.fft.rfft(signal * np.hanning(signal.shape[1]))


def _mean_frequency(power: Array, samples: int) -> Array:
    """Mean frequency in cycles a sample of the power beyond that of white noise; 0 where none is.

    Args:
        power: mean over windows of the tapered spectra, shape (..., f).
        samples: of a window.
    """
    beyond = power - _white(power, samples)[..., None] * _flat(samples)
    total = beyond.sum(-1)
    return beyond @ np.fft.rfftfreq(samples) / np.where(total > 0, total, np.inf)


def _white(power: Array, samples: int) -> Array:
    """Variance of the white noise by the upper half of the frequencies, 1 at most."""
    return np.minimum(power[..., power.shape[-1] // 2 :].mean(-1) / _flat(samples), 1.0)


def _flat(samples: int) -> float:
    """Power of white noise of variance 1 at each frequency."""
    return float((np.hanning(samples) ** 2).sum())


def _detrended(residual: Array) -> Array:
    basis = np.linalg.qr(legvander(np.linspace(-1, 1, residual.shape[1]), _TERMS - 1))[0]
    return residual - residual @ basis @ basis.T
