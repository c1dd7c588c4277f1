"""How far the simulation strays from the measurements: by horizon, and in step with the input."""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.windows.commands import steps_at
from dr_lab.trajectory import Array

_CONFIDENCE = 0.99  # as MATLAB's resid


@dataclass(frozen=True)
class HorizonError:
    """Root mean square error against the time since the start was last known.

    Attributes:
        horizon: upper edges of the bins, s, shape (h,).
        rmse: error by channel, in the channel's unit, shape (h,).
    """

    horizon: Array
    rmse: dict[str, Array]


def horizon_error(replay: Replay, fit: Point, run_in: float, margin: float, bins: int) -> HorizonError:
    """Error of predicted windows in bins of the time since their last known sample; the first bin is one step ahead.

    Args:
        replay: windows whose starts are fitted on the samples before the scored part.
        fit: fit of those starts.
        run_in: time of the known samples, s.
        margin: simulated time before them, s.
        bins: number of bins, evenly spread on a logarithmic scale; a single one is the whole window.
    """
    last = max(float(s.time[s.scored].max()) for s in replay.windows.samples if s.scored.any()) - run_in - margin
    edges = np.concatenate([[0.0], np.geomspace(min(_spacing(replay), last), last, bins)])
    edges[-1] = last
    rmse = {}
    for samples, residual in replay.by_channel(fit.residuals):
        error = residual * samples.std
        used = samples.scored & ~fit.infeasible[:, None]
        age = samples.time[used] - run_in - margin
        square = (error[used] ** 2).mean(-1)
        total, count = (np.histogram(age, edges, weights=w)[0] for w in (square, np.ones_like(square)))
        rmse[samples.channel.name] = np.sqrt(np.divide(total, count, out=np.full(bins, np.nan), where=count > 0))
    return HorizonError(edges[1:], rmse)


def _spacing(replay: Replay) -> float:
    """Time between two samples of the slowest channel that has two in a window, s."""
    gaps = [np.diff(s.time, axis=1)[s.scored[:, 1:] & s.scored[:, :-1]] for s in replay.windows.samples]
    return max((float(np.median(gap)) for gap in gaps if len(gap)), default=replay.windows.step)


@dataclass(frozen=True)
class InputCorrelation:
    """Cross-correlation of a residual with a command.

    Attributes:
        signal: channel of the residual (of a vector its first component).
        command: the command.
        lag: lags in steps, shape (l,); at a positive lag the command precedes the residual.
        correlation: coefficient at each lag, shape (l,).
        band: what the largest of these coefficients stays below by chance at 99 %, widened for the residual's own
            colour.
        step: s per lag.
    """

    signal: str
    command: str
    lag: Array
    correlation: Array
    band: float
    step: float

    @property
    def peak(self) -> tuple[float, float]:
        """Lag in s and value of the largest coefficient."""
        k = int(np.argmax(np.abs(self.correlation)))
        return float(self.lag[k] * self.step), float(self.correlation[k])


def input_correlations(replay: Replay, fit: Point, commands: dict[str, int], lags: int) -> list[InputCorrelation]:
    """Correlate every channel's residual with every command, over windows laid on the steps' grid.

    The 99 % band is z/√n_eff with n_eff = n / Σ_k (1 − |k|/m) ρ_r(k) ρ_u(k) over all lags |k| < m of a window of m
    samples (Bartlett 1935), so that neither coloured residuals nor commands held for longer than the lags shown pass
    for missing physics, and z such that the largest coefficient of all lags stays within it (Šidák 1967). A peak at a
    positive lag says that u(t − lag) → y is mis-modelled; at negative lags it is feedback.

    Args:
        replay: windows.
        fit: their fit; windows whose simulation diverges are left out.
        commands: column in ctrl by command name.
        lags: largest lag in samples either way; at most a quarter of a window.

    Returns:
        One entry per channel and command; none where a channel has too few samples in a window.
    """
    found, kept = [], ~fit.infeasible
    controls = replay.windows.controls[kept]
    for samples, residual in replay.by_channel(fit.residuals):
        used = samples.scored[kept].all(0)
        most = min(lags, int(used.sum()) // 4)
        if not kept.any() or most < 1:
            continue
        time, error = samples.time[kept], residual[kept][:, used, 0]
        step = float(np.median(np.diff(time[:, used], axis=1)))
        index = steps_at(time, replay.windows.step, controls.shape[1])
        for command, ctrl in commands.items():
            u = np.take_along_axis(controls[..., ctrl], index, axis=1)[:, used]
            found.append(_correlate(samples.channel.name, command, error, u, most, step))
    return found


def _correlate(signal: str, command: str, error: Array, u: Array, lags: int, step: float) -> InputCorrelation:
    error, u = (x - x.mean() for x in (error, u))
    lag = range(-lags, lags + 1)
    correlation = np.array([_at_lag(u, error, k) for k in lag])
    each = _CONFIDENCE ** (1 / len(lag))  # of every lag, so that all hold together
    band = float(ndtri((1 + each) / 2) / np.sqrt(_independent(error, u)))
    return InputCorrelation(signal, command, np.array(lag, float), correlation, band, step)


def _independent(error: Array, u: Array) -> float:
    """Number of independent samples among the products of two signals of mean 0, shape (w, m) each."""
    m = error.shape[1]
    spectra = (np.abs(np.fft.rfft(np.stack([error, u]), 2 * m)) ** 2).sum(1)
    products = np.fft.irfft(spectra)[:, :m]  # Σ x(t) x(t + k) over all windows
    error_at, u_at = products / np.where(products[:, :1] > 0, products[:, :1], 1.0)
    colour = error_at * u_at / (1 - np.arange(m) / m)  # either of them holds the factor 1 − k/m of the shorter overlap
    return error.size / max(1.0, 2 * float(colour.sum()) - float(colour[0]))


def _at_lag(first: Array, second: Array, lag: int) -> float:
    """Correlation of first(t − lag) with second(t), windows kept apart."""
    m = first.shape[1]
    a = first[:, max(0, -lag) : m - max(0, lag)]
    b = second[:, max(0, lag) : m - max(0, -lag)]
    scale = np.sqrt((first**2).mean() * (second**2).mean())
    return float((a * b).mean() / scale) if scale > 0 else 0.0
