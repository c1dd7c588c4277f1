"""Times that no log of a machine has: nanoseconds read as seconds or the reverse, a stamp from another epoch."""

import numpy as np

from dr_lab.errors import DataError
from dr_lab.measurements.cleaning import period
from dr_lab.measurements.contract import DataContract
from dr_lab.trajectory import Array

CLOCKS = ("header", "publish", "log")  # of an MCAP file, to choose from

_UNITS = {"ms": 1e-3, "µs": 1e-6, "ns": 1e-9}
_DIGITS, _MOST_DIGITS = 6, 17
_TYPICAL = 3e-3  # s, in the middle of 20 Hz and 5 kHz on a logarithmic scale


def check_sampling(name: str, time: Array, clock: str, contract: DataContract) -> None:
    """Refuse times that are too far apart or too close to be seconds, or too far to be those of one motion.

    Args:
        name: channel, for messages.
        time: increasing, in what is declared as s, shape (n,).
        clock: whose stamps they are, ``header``, ``publish``, ``log`` or ``column``.
        contract: how far is too far.

    Raises:
        DataError: samples usually lie too far apart or too close, or a few stamps or stretches lie far from all others.
    """
    if len(time) < 2:
        return
    waits = np.diff(time)
    usual, single, span = period(time), float(np.median(waits)), float(time[-1] - time[0])
    if min(usual, single) > contract.longest_period:
        raise DataError(
            f"{name} has a sample every {usual:.3g} s, {len(time)} in {span:.3g} s; its times seem to be in another "
            f"unit than s. {_other_unit(usual, clock)}, or raise contract.longest_period "
            f"({contract.longest_period:g} s) if it is that slow."
        )
    if max(usual, single) < contract.shortest_period:
        raise DataError(
            f"{name} has a sample every {usual:.3g} s, {len(time)} in {span:.3g} s; its times seem to be in another "
            f"unit than declared. {_longer_unit(usual, clock)}, or lower contract.shortest_period "
            f"({contract.shortest_period:g} s) if it is that fast."
        )
    crowded = span / len(waits) <= contract.longest_mean_wait
    if usual <= contract.longest_period and crowded:
        return
    far = int(waits.argmax())
    limit = "longest_period" if crowded else "longest_mean_wait"
    longest = contract.gap * single if crowded else contract.longest_mean_wait
    raise DataError(
        f"{name} has {len(time)} samples in {span:.3g} s, usually one every {single:.3g} s: stamps lie far from the "
        f"others, {waits[far]:.3g} s pass after {time[far]:.6g} s. {_remedy(time, waits, longest, contract)}, mend "
        f"them, or raise contract.{limit} ({getattr(contract, limit):g} s). If only changes are published, have it "
        "published at a steady rate: what would have been measured in a pause is not known."
    )


def _remedy(time: Array, waits: Array, longest: float, contract: DataContract) -> str:
    """How to keep the stretch with the most samples and no longer wait than the longest, if they are enough."""
    pauses = np.flatnonzero(waits > longest)
    begins, ends = np.append(0, pauses + 1), np.append(pauses + 1, len(time))
    most = int((ends - begins).argmax())
    begin, end = int(begins[most]), int(ends[most])
    if end - begin < contract.minimum_samples:
        return f"No stretch between such pauses has {contract.minimum_samples} samples; record it anew"
    cuts = [f"time.start={_between(time[begin - 1], time[begin])}"] if begin else []
    cuts += [f"time.stop={_between(time[end - 1], time[end])}"] if end < len(time) else []
    return f"Cut them off with {' and '.join(cuts)}, for this log alone with [a:b] behind its name"


def _between(low: float, high: float) -> str:
    """The middle of two times, with as many digits as it takes to lie between them."""
    written = (f"{(low + high) / 2:.{digits}g}" for digits in range(_DIGITS, _MOST_DIGITS))
    return next((text for text in written if low < float(text) < high), repr(float(low + high) / 2))


def _longer_unit(usual: float, clock: str) -> str:
    if clock != "column":
        return _another(clock)
    factor = min(_UNITS.values(), key=lambda size: abs(np.log(usual / size / _TYPICAL)))
    return f"If they are {1 / factor:.0e} times longer, correct time.unit or time.scale".replace("e+0", "e")


def _another(clock: str) -> str:
    return f"Choose another clock than {clock}: {' or '.join(c for c in CLOCKS if c != clock)}"


def _other_unit(usual: float, clock: str) -> str:
    if clock != "column":
        return _another(clock)
    unit = min(_UNITS, key=lambda name: abs(np.log(usual * _UNITS[name] / _TYPICAL)))
    return f"If they are in {unit}, set time.scale={_UNITS[unit]:.0e}".replace("e-0", "e-")
