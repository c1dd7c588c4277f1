"""Local polynomials through what channels measured, at the windows' starts."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.channels import Channel
from dr_lab.diagnosis.windows.orientations import continuous
from dr_lab.measurements.smoothing import LocalFit, local_polynomial
from dr_lab.trajectory import Array, Log, Signal

DEGREE = 3  # of the local polynomials


def starts_known(signal: Signal, begins: Array, settings: WindowSettings) -> NDArray[np.bool_]:
    """Which starts have enough samples that they may know of."""
    if settings.run_in <= 0:
        return np.full(len(begins), len(signal) > DEGREE)
    return np.searchsorted(signal.time, begins + (settings.margin + settings.run_in)) > DEGREE


def fits(logs: Sequence[Log], name: str, begins: Sequence[Array], settings: WindowSettings) -> tuple[Array, Array]:
    """Value, slope and curvature at each start, shape (3, w), and what the polynomial misses of each, shape (3,)."""
    signals = [log.outputs[name] for log in logs]
    wide, narrow = (
        np.stack(_local(signals, begins, width, settings)) for width in (settings.smoother, settings.smoother / 2)
    )
    return wide, np.sqrt(((wide - narrow) ** 2).mean(1))


def vectors(
    logs: Sequence[Log], channel: Channel, begins: Sequence[Array], width: float, settings: WindowSettings
) -> tuple[Array, Array, Array]:
    """Value, slope and curvature of a vector channel at each start, shape (w, size) each."""
    signals = [log.outputs[channel.name] for log in logs]
    if channel.kind == "orientation":
        signals = [replace(signal, value=continuous(signal.value)) for signal in signals]
    return _local(signals, begins, width, settings)


def _local(
    signals: Sequence[Signal], begins: Sequence[Array], width: float, settings: WindowSettings
) -> tuple[Array, Array, Array]:
    """Value, slope and curvature at each start, from samples that it may know of, shape (w,) or (w, size) each."""
    lead = settings.margin + settings.run_in
    fits = []
    for signal, begin in zip(signals, begins, strict=True):
        # A sample at the end of the run-in belongs to the scored part.
        known = np.nextafter(begin + lead, -np.inf) if settings.run_in > 0 else np.inf
        fits.append(local_polynomial(signal, begin, width, until=known, degree=DEGREE))
    value, slope, curvature = (np.concatenate([getattr(f, part) for f in fits]) for part in LocalFit._fields[:3])
    return value, slope, curvature
