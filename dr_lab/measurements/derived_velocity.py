"""Velocities that a drive or a script made of the logged positions: they tell of the motion what the positions tell."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from dr_lab.channel_names import POSITION, VELOCITY, joint_of, quantity
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.lattice import lattice_step
from dr_lab.trajectory import Array, Log, Noise, Note, Signal

_SAME_TIME = 1e-6  # s, up to which two samples are of one instant
_ROUNDS = 5  # of Steiglitz and McBride; a filter of first order is exact after the first
_SETTLING = 60  # samples in which a filter of unknown past settles: e^-11 of it is left at a corner of rate / 35
_LATE = 1.5  # usual times between samples, beyond which one is missing
_FEWEST = 200  # samples that a filter is worth
_TAIL = 400  # samples of an impulse response
_FREQUENCIES = 8192  # points of a response's Fourier transform
# Share of a step up to which rounding makes nearly all samples differ: a half, and what a fitted filter errs by. Of a
# velocity made elsewhere, whose noise is no less than a step's, one sample in nine is farther off.
_ROUNDED = 0.65
_NEARLY = 0.98


class _Shape(NamedTuple):
    """How many differences behind and ahead of a sample, and how many velocities before it, make a velocity."""

    back: int
    ahead: int
    order: int


# From the simplest on: a difference; one that is low-passed; by a filter of second order; any window of 17 differences,
# central differences, moving means and Savitzky–Golay filters among them.
_SHAPES = (_Shape(0, 0, 0), _Shape(0, 0, 1), _Shape(2, 0, 2), _Shape(8, 8, 0))


@dataclass(frozen=True)
class Derived:
    """A filter that makes a joint's velocity samples of its position samples.

    Attributes:
        share: RMS of what it leaves of the velocity, in the noise that it makes of the position's noise.
        delay: s, by which a slow velocity comes late.
        corner: Hz, at which half of the power is left; infinite if more is left everywhere.
        period: s, between two samples.
        rounded: whether what it leaves is no more than the velocity's own rounding.
    """

    share: float
    delay: float
    corner: float
    period: float
    rounded: bool = False

    def note(self, position: str, velocity: str) -> Note:
        """What the user reads."""
        smooth = f", low-passed at {self.corner:.3g} Hz" if np.isfinite(self.corner) else ""
        repeats = "its own rounding" if self.rounded else f"{100 * self.share:.2g} %"
        message = (
            f"{velocity} is the difference of {position} over samples of {1e3 * self.period:.3g} ms{smooth} "
            f"({1e3 * self.delay:.3g} ms late): it repeats the position's noise to within {repeats}. "
            f"What it tells of the motion {position} tells already, so that it is left out; "
            "measurements.contract.derived=0 keeps it."
        )
        return Note("derived", velocity, message)


def without_derived(
    logs: Sequence[Log], noise: Mapping[str, Noise], contract: DataContract
) -> tuple[tuple[Log, ...], frozenset[str]]:
    """The logs without velocities that are a filter's output of the logged positions, with a note on each.

    A filter F that is driven by the logged samples y = q + n gives v = F q + F n, while a velocity that was measured or
    made elsewhere does not know n, and v − F y holds F n. So v is made of y where v − F y is far smaller than
    std(n) ‖F‖ for any of a few filters, or nowhere more than v's own rounding to whole rpm or the like, if that is too
    fine to hide a noise of std(n) ‖F‖. Given y it then says nothing of q, whatever the filter, and counting it beside y
    would count the same noise twice.

    Args:
        logs: all logs.
        noise: of each measured channel.
        contract: `derived` is the largest share of std(n) ‖F‖ that may be left, in every log that is long enough to
            tell, of which there is one at least.

    Returns:
        The logs, and the channels that were left out.
    """
    names = [name for name in logs[0].outputs if quantity(name) == VELOCITY]
    found: dict[str, Note] = {}
    for name in names if contract.derived > 0 else ():
        place = f"{joint_of(name)}.{POSITION}"
        if place in logs[0].outputs:
            pairs = [(log.outputs[place], log.outputs[name]) for log in logs if _tells(log.outputs[place])]
            each = [derived(*pair, noise[place].std, contract.derived) for pair in pairs]
            known = [one for one in each if one is not None]
            if known and len(known) == len(each):
                found[name] = max(known, key=lambda one: one.share).note(place, name)
    return tuple(_without(log, found) for log in logs), frozenset(found)


def derived(position: Signal, velocity: Signal, std: float, most: float) -> Derived | None:
    """The simplest filter that makes one of the other and leaves at most a share of its noise; None if none does.

    Differences are divided by the time between their samples as stamped, or by the usual one.

    Args:
        position: q with its noise, rad or m.
        velocity: rad/s or m/s, at the same times.
        std: of the position's noise.
        most: share of the filter's noise that may be left.

    Source: Steiglitz and McBride, IEEE Trans. Automatic Control 10 (1965) 461.
    """
    time, value = position.time, velocity.value
    if len(time) != len(velocity) or np.abs(time - velocity.time).max() > _SAME_TIME:
        return None
    if not _tells(position):
        return None
    steps, settled = np.diff(time), _settled(time)
    period, rounding = float(np.median(steps)), lattice_step(value) or 0.0
    for wait in (steps, np.full(len(steps), period)):
        rough = np.append(0.0, np.diff(position.value) / wait)
        for shape in _SHAPES:
            found = _fitted(rough, value, shape, settled[settled < len(time) - shape.ahead])
            one = found and _described(found, shape, period, std, rounding)
            if one and (one.rounded or one.share <= most):
                return one
    return None


def _tells(position: Signal) -> bool:
    """Whether there are samples enough for a filter to be told from none."""
    return len(_settled(position.time)) >= _FEWEST


def _settled(time: Array) -> NDArray[np.intp]:
    """Samples before which none is missing for so long that a filter has settled."""
    steps = np.diff(time)
    if len(steps) < _SETTLING:
        return np.empty(0, np.intp)
    late = np.append(0.0, steps > _LATE * float(np.median(steps)))
    settled = np.flatnonzero(np.convolve(late, np.ones(_SETTLING))[: len(time)] < 0.5)
    return settled[settled >= _SETTLING]


class _Filter(NamedTuple):
    """Coefficients, those ahead of the sample first, those of the velocities before it (1, −a₁ …), and what is left.

    That is told by its RMS, and by what nearly all samples stay below.
    """

    direct: Array
    recursive: Array
    left: float
    most: float


def _fitted(rough: Array, value: Array, shape: _Shape, rows: NDArray[np.intp]) -> _Filter | None:
    """Least squares of a filter's output error in some rows; None where no stable filter is found."""
    recursive, direct = np.eye(1, shape.order + 1)[0], np.zeros(0)
    for _ in range(_ROUNDS if shape.order else 1):
        past, drive = (np.asarray(lfilter([1.0], recursive, series)) for series in (value, rough))
        columns = [past[rows - i] for i in range(1, shape.order + 1)]
        columns += [drive[rows - j] for j in range(-shape.ahead, shape.back + 1)]
        best = np.linalg.lstsq(np.stack(columns, axis=1), past[rows], rcond=None)[0]
        direct, recursive = best[shape.order :], np.append(1.0, -best[: shape.order])
        if shape.order and np.abs(np.roots(recursive)).max() >= 1.0:
            return None
    made = np.asarray(lfilter(direct, recursive, np.append(rough, np.zeros(shape.ahead))))[shape.ahead :]
    left = (value - made)[rows]
    return _Filter(direct, recursive, float(np.sqrt((left**2).mean())), float(np.quantile(np.abs(left), _NEARLY)))


def _described(found: _Filter, shape: _Shape, period: float, std: float, rounding: float) -> Derived | None:
    """The filter in words' numbers; None where it passes no steady velocity."""
    pulse = np.eye(1, _TAIL + len(found.direct))[0]
    response = np.asarray(lfilter(found.direct, found.recursive, pulse))
    noise = std / period * float(np.linalg.norm(np.convolve(response, [1.0, -1.0])))
    if not noise > 0.0 or not response.sum() > 0.0:
        return None
    late = float(response @ (np.arange(len(response)) - shape.ahead) / response.sum()) + 0.5
    passed = np.abs(np.fft.rfft(response, _FREQUENCIES))
    weak = np.flatnonzero(passed < np.sqrt(0.5) * passed[0])
    corner = float(np.fft.rfftfreq(_FREQUENCIES, period)[weak[0]]) if len(weak) else np.inf
    rounded = found.most <= _ROUNDED * rounding and rounding <= np.sqrt(12) * noise
    return Derived(found.left / noise, late * period, corner, period, rounded)


def _without(log: Log, found: Mapping[str, Note]) -> Log:
    """The log without the channels that were found, with a note on each."""
    outputs = {name: signal for name, signal in log.outputs.items() if name not in found}
    return replace(log, outputs=outputs, notes=(*log.notes, *found.values()))
