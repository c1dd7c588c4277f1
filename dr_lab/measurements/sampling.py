"""Times that no log of a machine has: nanoseconds read as seconds, a stamp from another epoch."""

import numpy as np

from dr_lab.errors import DataError
from dr_lab.measurements.cleaning import period
from dr_lab.measurements.contract import DataContract
from dr_lab.trajectory import Array

_UNITS = {"ms": 1e-3, "µs": 1e-6, "ns": 1e-9}
_TYPICAL = 3e-3  # s, in the middle of 20 Hz and 5 kHz on a logarithmic scale


def check_sampling(name: str, time: Array, clock: str, contract: DataContract) -> None:
    """Refuse times that are too far apart to be seconds.

    Args:
        name: channel, for messages.
        time: increasing, in what is declared as s, shape (n,).
        clock: whose stamps they are, ``header``, ``publish``, ``log`` or ``column``.
        contract: how far is too far.

    Raises:
        DataError: samples usually lie too far apart, or a few stamps lie far from all others.
    """
    if len(time) < 2:
        return
    usual, span = period(time), float(time[-1] - time[0])
    if usual > contract.longest_period:
        raise DataError(
            f"{name} has a sample every {usual:.3g} s, {len(time)} in {span:.3g} s; its times seem to be in another "
            f"unit than s. {_other_unit(usual, clock)}, or raise contract.longest_period "
            f"({contract.longest_period:g} s) if it is that slow."
        )
    if span / (len(time) - 1) > contract.longest_mean_wait:
        waits = np.diff(time)
        far = int(waits.argmax())
        cut = "start" if far < len(waits) / 2 else "stop"
        raise DataError(
            f"{name} has {len(time)} samples in {span:.3g} s, usually one every {usual:.3g} s: stamps lie far from the "
            f"others, {waits[far]:.3g} s pass after {time[far]:.6g} s. Cut them off with "
            f"time.{cut}={time[far] + waits[far] / 2:.6g}, mend them, or raise contract.longest_mean_wait."
        )


def _other_unit(usual: float, clock: str) -> str:
    if clock != "column":
        return f"Choose another clock than {clock}: header, publish or log"
    unit = min(_UNITS, key=lambda name: abs(np.log(usual * _UNITS[name] / _TYPICAL)))
    return f"If they are in {unit}, set time.scale={_UNITS[unit]:.0e}".replace("e-0", "e-")
