"""Local polynomials through what channels measured, at the windows' starts."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.channels import Channel
from dr_lab.diagnosis.windows.orientations import continuous
from dr_lab.measurements.smoothing import LocalFit, local_polynomial
from dr_lab.trajectory import Array, Log, Signal

DEGREE = 3  # of the local polynomials


class Reach(NamedTuple):
    """Which samples a local polynomial takes: those within a half-width in s, and where these are fewer the nearest."""

    half_width: float
    least: int


def reaches(settings: WindowSettings) -> tuple[Reach, Reach]:
    """Of a polynomial, and of a narrower one: what the first misses of the motion shows in how much they differ.

    Where samples are rare neither half-width holds enough of them; then the narrower one takes fewer of the nearest.
    """
    return Reach(settings.smoother, 2 * DEGREE), Reach(settings.smoother / 2, DEGREE + 2)


def starts_known(signal: Signal, begins: Array, settings: WindowSettings) -> NDArray[np.bool_]:
    """Which starts have enough samples that they may know of."""
    if settings.run_in <= 0:
        return np.full(len(begins), len(signal) > DEGREE)
    return np.searchsorted(signal.time, begins + (settings.margin + settings.run_in)) > DEGREE


def fits(logs: Sequence[Log], name: str, begins: Sequence[Array], settings: WindowSettings) -> tuple[Array, Array]:
    """Value, slope and curvature at each start, shape (3, w), and what the polynomial misses of each, shape (3,)."""
    signals = [log.outputs[name] for log in logs]
    wide, narrow = (np.stack(_local(signals, begins, reach, settings)) for reach in reaches(settings))
    return wide, np.sqrt(((wide - narrow) ** 2).mean(1))


def vectors(
    logs: Sequence[Log], channel: Channel, begins: Sequence[Array], reach: Reach, settings: WindowSettings
) -> tuple[Array, Array, Array]:
    """Value, slope and curvature of a vector channel at each start, shape (w, size) each."""
    signals = [log.outputs[channel.name] for log in logs]
    if channel.kind == "orientation":
        signals = [replace(signal, value=continuous(signal.value)) for signal in signals]
    return _local(signals, begins, reach, settings)


def _local(
    signals: Sequence[Signal], begins: Sequence[Array], reach: Reach, settings: WindowSettings
) -> tuple[Array, Array, Array]:
    """Value, slope and curvature at each start, from samples that it may know of, shape (w,) or (w, size) each."""
    lead = settings.margin + settings.run_in
    fits = []
    for signal, begin in zip(signals, begins, strict=True):
        # A sample at the end of the run-in belongs to the scored part.
        known = np.nextafter(begin + lead, -np.inf) if settings.run_in > 0 else np.inf
        fits.append(local_polynomial(signal, begin, reach.half_width, known, DEGREE, reach.least))
    value, slope, curvature = (np.concatenate([getattr(f, part) for f in fits]) for part in LocalFit._fields[:3])
    return value, slope, curvature
