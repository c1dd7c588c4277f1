"""Units by name, to SI."""

import difflib
import re
from dataclasses import dataclass
from functools import cache

import pint

from dr_lab.errors import DataError

# Derived units that keep their usual name; all others are written in base units, e.g. m/s² or rad/s.
_NAMED = ("N", "N·m", "V", "Ω", "Pa", "W", "T")
# Units of machines, of which a misspelt one is told the nearest.
_USUAL = (
    *("rad", "mrad", "deg", "turn", "rad/s", "deg/s", "rpm", "rad/s^2", "m", "mm", "um", "m/s", "mm/s", "m/s^2"),
    *("N", "kN", "N·m", "mN·m", "V", "mV", "A", "mA", "percent", "1"),
)
# Pint reads "Nm" as number/meter, a unit of yarn.
_NEWTON_METRE = re.compile(r"\b([a-zµ]?N)m\b")


@dataclass(frozen=True)
class Unit:
    """A unit and its way to SI.

    Attributes:
        given: as the user wrote it.
        name: its coherent SI unit.
        factor: value in SI = factor · value in the given unit.
        dimension: physical dimension, in pint's words; angles have none.
    """

    given: str
    name: str
    factor: float
    dimension: str


@cache
def _registry() -> pint.UnitRegistry:
    return pint.UnitRegistry()


@cache
def unit(text: str) -> Unit:
    """Look a unit up.

    Args:
        text: e.g. ``"deg"``, ``"rad/s"``, ``"N·m"``, ``"mV"``; ``"1"`` for a number without one.

    Raises:
        DataError: there is no such unit, or it has an offset (°C).
    """
    registry = _registry()
    if text.lower() == "grad":  # German for degrees, and pint's name of a four-hundredth of a turn
        raise DataError("The unit 'grad' may be a degree or a gon. Write deg, or gon.")
    try:
        parsed = registry.Unit("" if text == "1" else _NEWTON_METRE.sub(r"\1*m", text))
        base = registry.Quantity(1.0, parsed).to_base_units()
        zero = registry.Quantity(0.0, parsed).to_base_units()
    except Exception as error:
        # Pint raises its own errors, tokenizer errors and TypeErrors, depending on the text.
        meant = _meant(text)
        near = f"Did you mean {meant!r}? " if meant else ""
        remedy = f"{near}Write it as e.g. rad, deg, rad/s, rpm, m, N, N·m, V or 1."
        raise DataError(f"There is no unit {text!r} ({error}). {remedy}") from error
    if zero.magnitude != 0.0:
        raise DataError(f"Unit {text!r} has an offset; give the value in an absolute unit, e.g. K.")
    name = next((n for n in _NAMED if base.is_compatible_with(registry.Unit(n))), f"{base.units:~P}") or "1"
    return Unit(text, name, float(base.magnitude), str(base.dimensionality))


def _meant(text: str) -> str:
    """The unit that a wrong one may stand for: in other letters of case, or misspelt; empty where there is none."""
    if text.isalpha() and text.lower() in _registry():  # of other texts, such as RPM/, pint may fail to say so
        return text.lower()
    return next(iter(difflib.get_close_matches(text, _USUAL, n=1)), "")
