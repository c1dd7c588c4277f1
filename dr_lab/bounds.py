"""Bounds of numbers, stated where a class declares them: ``epsilon: Annotated[float, above(0.0), at_most(1.0)]``."""

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from math import isfinite
from typing import Annotated

from dr_lab.errors import ConfigError


@dataclass(frozen=True)
class Bound:
    """What must hold of a number; no comparison holds of NaN.

    Attributes:
        holds: whether it does.
        expected: the numbers of which it holds, in words.
    """

    holds: Callable[[float], bool]
    expected: str

    def fault(self, key: str, value: float) -> str:
        """What to say where it does not hold of the value of a key."""
        return f"{key} is {value:g}; expected {self.expected}."


def above(end: float) -> Bound:
    """A number above `end`."""
    return Bound(lambda value: value > end, f"a number above {end:g}")


def at_least(low: float) -> Bound:
    """A number not below `low`."""
    return Bound(lambda value: value >= low, f"at least {low:g}")


def at_most(high: float) -> Bound:
    """A number not above `high`."""
    return Bound(lambda value: value <= high, f"at most {high:g}")


def below(end: float) -> Bound:
    """A number below `end`."""
    return Bound(lambda value: value < end, f"a number below {end:g}")


Positive = Annotated[float, above(0.0)]
NotNegative = Annotated[float, at_least(0.0)]
Share = Annotated[float, Bound(lambda value: 0.0 < value < 1.0, "a share between 0 and 1")]
Confidence = Annotated[float, Bound(lambda value: 0.0 < value < 1.0, "a share between 0 and 1, such as 0.95")]
Count = Annotated[int, at_least(1)]
Natural = Annotated[int, at_least(0)]


def require_bounds(built: object, key: str, declared: type | None = None) -> None:
    """Check the numbers of an object by the bounds that its class states at its fields, or its ``__init__``.

    Args:
        built: holds the numbers as attributes; None where a number is left out, which is within its bounds.
        key: where the numbers stand in the configuration, for the message; empty at its root.
        declared: class that states the bounds at its ``__init__``; None takes the object's own, a dataclass.

    Raises:
        ConfigError: a number is out of its bounds or not a number.
    """
    for name, bounds in _bounds(declared or type(built)).items():
        value = getattr(built, name)
        fault = None if value is None else next((bound for bound in bounds if not bound.holds(value)), None)
        if fault is not None and value is not None:
            raise ConfigError(fault.fault(f"{key}{'.' if key else ''}{name}", value))


def require_range(given: Sequence[float], key: str, unit: str) -> None:
    """Check a range that is written as [low, high].

    Args:
        given: the range.
        key: where it stands in the configuration, for the message.
        unit: of its ends.

    Raises:
        ConfigError: it is not two finite numbers in order.
    """
    if len(given) != 2 or not all(map(isfinite, given)) or not given[0] < given[1]:
        raise ConfigError(f"{key} is {list(given)} {unit}; expected [low, high] with low < high.")


@cache
def _bounds(declared: type) -> dict[str, tuple[Bound, ...]]:
    """The bounds that a class states, by the name of what they bound."""
    parameters = inspect.signature(declared).parameters
    stated = {name: getattr(p.annotation, "__metadata__", ()) for name, p in parameters.items()}
    found = {name: tuple(b for b in metadata if isinstance(b, Bound)) for name, metadata in stated.items()}
    return {name: bounds for name, bounds in found.items() if bounds}
