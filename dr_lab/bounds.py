"""Bounds of numbers, stated where a class declares them: ``epsilon: Annotated[float, above(0.0), at_most(1.0)]``."""

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from math import isfinite
from typing import Annotated, Any

from dr_lab.errors import ConfigError


@dataclass(frozen=True)
class Bound:
    """What must hold of a number, or of a list of numbers; no comparison holds of NaN.

    Attributes:
        holds: whether it does.
        expected: the numbers of which it holds, in words.
    """

    holds: Callable[[Any], bool]
    expected: str

    def fault(self, key: str, value: float | Sequence[object]) -> str:
        """What to say where it does not hold of the value of a key."""
        given = f"{value:g}" if isinstance(value, int | float) else str(value)
        return f"{key} is {given}; expected {self.expected}."


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


FINITE = Bound(isfinite, "a finite number")


def numbers(count: int | None, *bounds: Bound) -> Bound:
    """A list of so many numbers, None: of any length, of each of which the bounds hold."""
    words = [bound.expected for bound in bounds if bound is not FINITE]
    kind = "finite numbers" if FINITE in bounds else "numbers"
    expected = ", each ".join([kind if count is None else f"{count} {kind}", *words])

    def holds(values: object) -> bool:
        listed = _is_list(values, count)
        return listed is not None and all(bound.holds(value) for value in listed for bound in bounds)

    return Bound(holds, expected)


def places(holds: Callable[[float, float], bool], expected: str) -> Bound:
    """Two places in the plane, finite [[x, y], [x, y]], of whose x and of whose y something holds."""

    def both(values: object) -> bool:
        rows = [_is_list(row, 2) for row in _is_list(values, 2) or ()]
        if len(rows) < 2 or rows[0] is None or rows[1] is None:
            return False
        return all(map(isfinite, [*rows[0], *rows[1]])) and all(map(holds, rows[0], rows[1]))

    return Bound(both, f"[[x, y], [x, y]], {expected}")


def _is_list(values: Any, count: int | None) -> Sequence[Any] | None:  # noqa: ANN401
    """The values, where they are a list of so many."""
    listed = isinstance(values, Sequence) and not isinstance(values, str) and count in (None, len(values))
    return values if listed else None


ORDERED = Bound(
    lambda values: _is_list(values, 2) is not None and values[0] < values[1], "[lowest, highest], lowest < highest"
)
RISING = Bound(
    lambda values: _is_list(values, 2) is not None and values[0] <= values[1], "[lowest, highest], lowest <= highest"
)
Finite = Annotated[float, FINITE]
Positive = Annotated[float, above(0.0), FINITE]
NotNegative = Annotated[float, at_least(0.0), FINITE]
Limit = Annotated[float, above(0.0)]
"""A number above 0 that nothing goes beyond; inf where there is no limit."""
Share = Annotated[float, Bound(lambda value: 0.0 < value < 1.0, "a share between 0 and 1")]
Confidence = Annotated[float, Bound(lambda value: 0.0 < value < 1.0, "a share between 0 and 1, such as 0.95")]
Count = Annotated[int, at_least(1)]
Natural = Annotated[int, at_least(0)]


def require_bounds(built: object, key: str, declared: type | None = None) -> None:
    """Check the numbers of an object, and its lists of them, by the bounds that its class states where it takes them.

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
        raise ConfigError(f"{key} is {list(given)} {unit}; expected finite [low, high] with low < high.")


@cache
def _bounds(declared: type) -> dict[str, tuple[Bound, ...]]:
    """The bounds that a class states, by the name of what they bound."""
    parameters = inspect.signature(declared).parameters
    stated = {name: getattr(p.annotation, "__metadata__", ()) for name, p in parameters.items()}
    found = {name: tuple(b for b in metadata if isinstance(b, Bound)) for name, metadata in stated.items()}
    return {name: bounds for name, bounds in found.items() if bounds}
