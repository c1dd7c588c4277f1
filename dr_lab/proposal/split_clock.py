"""A time that a table tells in two columns: one counts the seconds, the other holds the rest of each."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from dr_lab.proposal.tokens import tokens
from dr_lab.trajectory import Array

_SECONDS = {"s", "sec", "secs", "second", "seconds"}
# Last words of columns that may hold the rest of a second, with the unit, and how many of it a second has.
_RESTS = {
    **dict.fromkeys(("ms", "msec", "msecs", "millis", "millisec", "milliseconds"), ("ms", 10**3)),
    **dict.fromkeys(("us", "usec", "usecs", "micros", "microsec", "microseconds"), ("us", 10**6)),
    **dict.fromkeys(("ns", "nsec", "nsecs", "nanos", "nanosec", "nanosecs", "nanoseconds"), ("ns", 10**9)),
}


@dataclass(frozen=True)
class SplitClock:
    """Two columns that are a clock only together.

    Attributes:
        seconds: column of whole seconds.
        rest: column of the rest of each.
        unit: of the rest.
        parts: how many of that unit a second has.
    """

    seconds: str
    rest: str
    unit: str
    parts: int

    def __str__(self) -> str:
        """As messages say it, with what to do."""
        return (
            f"{self.seconds} counts the seconds and {self.rest} the {self.unit} of each, so that neither alone is a "
            f"clock. Add a column time_{self.unit} that holds {self.parts} · {self.seconds} + {self.rest}."
        )


def split_clocks(columns: Mapping[str, pa.ChunkedArray]) -> Iterator[SplitClock]:
    """The times that are told in two columns, which are called the same but for the last word, such as sec, nanosec.

    Args:
        columns: of a table, by name.
    """
    words = {name: tokens(name) for name in columns}
    for rest in columns:
        unit, parts = _RESTS.get("".join(words[rest][-1:]), ("", 0))
        for seconds in columns if parts else ():
            called = words[seconds][:-1] == words[rest][:-1] and bool({*words[seconds][-1:]} & _SECONDS)
            if called and _is_split(_numbers(columns[seconds]), _numbers(columns[rest]), parts):
                yield SplitClock(seconds, rest, unit, parts)


def _is_split(seconds: Array, rest: Array, parts: int) -> bool:
    """Whether numbers are whole seconds and less than one."""
    held = len(seconds) > 0 and len(rest) > 0
    return held and bool((seconds == np.round(seconds)).all() and rest.min() >= 0 and rest.max() < parts)


def _numbers(column: pa.ChunkedArray) -> Array:
    """The finite numbers of a column; none of one that holds no numbers."""
    if not (pa.types.is_integer(column.type) or pa.types.is_floating(column.type)):
        return np.empty(0)
    values = column.cast(pa.float64(), safe=False).to_numpy()
    return values[np.isfinite(values)]
