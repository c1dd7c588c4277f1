"""Numbers as a person reads them: rounded to what they are worth, with their unit."""

import math
from collections.abc import Iterable, Sequence

ABSENT = "–"
_WRITTEN_OUT = 6  # digits before the point up to which no power of ten is written
_COUNTED = 1e9  # whole numbers below it are counts, such as control steps, and have all their digits
_FEWEST, _FINEST = 3, 6  # significant digits of values beside one another
_LISTED = 6  # names
_NEARLY_ALL = 0.99  # share of one
_MOST = 10.0  # share of one, either sign, beyond which it says no more than that it is large


def number(value: float | None, digits: int = 4) -> str:
    """Round to `digits` significant digits; a missing or non-finite value is a dash.

    >>> number(0.00123456), number(-0.0)
    ('0.001235', '0')
    >>> number(1.5e-7, 2), number(123456), number(1234567)
    ('1.5e-7', '123500', '1.235e6')
    """
    if value is None or not math.isfinite(value):
        return ABSENT
    rounded = f"{value + 0.0:.{digits}g}"
    if "e+" in rounded and abs(float(rounded)) < 10.0**_WRITTEN_OUT:
        return f"{float(rounded):.0f}"
    return _short_exponent(rounded)


def written(value: float | str | None) -> str:
    """What stands in a table: words as they are, whole numbers with all their digits, others rounded.

    >>> written("hopper"), written(16384.0), written(16384.5), written(-0.0)
    ('hopper', '16384', '16380', '0')
    """
    if isinstance(value, str):
        return value
    if value is not None and abs(value) < _COUNTED and value == round(value):
        return f"{value + 0.0:.0f}"
    return number(value)


def in_unit(value: float | None, unit: str, digits: int = 4) -> str:
    """Round to `digits` significant digits, with the unit, which pure numbers do not have.

    >>> in_unit(0.2, "rad"), in_unit(3.0, "1"), in_unit(0.13784, "kg", 5)
    ('0.2 rad', '3', '0.13784 kg')
    """
    return number(value, digits) + _behind(unit)


def telling_apart(values: Iterable[float | None]) -> int:
    """How many digits show that values differ, three at least and not more than a fit is worth.

    >>> telling_apart([0.137812, 0.137845]), telling_apart([1.0, 2.0]), telling_apart([])
    (5, 3, 3)
    """
    known = [value for value in values if value is not None]
    apart = max(known, default=0.0) - min(known, default=0.0)
    if apart <= 0:
        return _FEWEST
    return min(max(_FEWEST, 2 + math.floor(math.log10(max(map(abs, known)) / apart))), _FINEST)


def uncertain(value: float | None, std: float | None, unit: str) -> str:
    """Value ± standard deviation: the deviation to two significant digits, the value to the same decimal place.

    Args:
        value: in `unit`.
        std: in `unit`; None or 0 where it is unknown, then the value stands alone.
        unit: unit's symbol, ``""`` for a pure number.

    >>> uncertain(0.0020031, 1.04e-5, "N·m")
    '0.002003 ± 0.000010 N·m'
    >>> uncertain(3.04e-6, 2e-8, "kg")
    '(3.040 ± 0.020)e-6 kg'
    """
    if value is None or std is None or not (math.isfinite(value) and math.isfinite(std)) or std <= 0:
        return in_unit(value, unit)
    exponent = math.floor(math.log10(max(abs(value), std)))
    power = 0 if -4 <= exponent < 5 else exponent
    scaled, deviation = value / 10.0**power, std / 10.0**power
    decimals = max(0, 1 - int(f"{deviation:.1e}".partition("e")[2]))
    text = f"{scaled:.{decimals}f} ± {deviation:.{decimals}f}"
    return (text if power == 0 else f"({text})e{power}") + _behind(unit)


def percent(share: float | None) -> str:
    """A share of one as whole per cent, one decimal below 10 % and above 99 %; what rounds to zero is 0.

    What is less than all is never rounded up to it. A share of more than ten, either sign, is only said to be that.

    >>> percent(0.953), percent(0.0123), percent(0.0)
    ('95 %', '1.2 %', '0 %')
    >>> percent(0.99996), percent(1.0)
    ('99.9 %', '100 %')
    >>> percent(-1.25e8), percent(366.0)
    ('below -1000 %', 'above 1000 %')
    """
    if share is None or not math.isfinite(share):
        return ABSENT
    if abs(share) > _MOST:
        return f"{'above ' if share > 0 else 'below -'}{100 * _MOST:.0f} %"
    if _NEARLY_ALL < share < 1.0:
        return f"{math.floor(1000 * share) / 10:.1f} %"
    text = f"{100 * share:.0f}" if abs(share) >= 0.1 else f"{100 * share:z.1f}"
    return "0 %" if text == "0.0" else f"{text} %"


def counted(count: int, what: str) -> str:
    """A number of things.

    >>> counted(1, "run"), counted(3, "run")
    ('1 run', '3 runs')
    """
    return f"{count} {what}{'s' * (count != 1)}"


def shortened(names: Sequence[str]) -> str:
    """Names one after the other, of many the first.

    >>> shortened(["a", "b"]), shortened(["a", "b", "c", "d", "e", "f", "g", "h"])
    ('a, b', 'a, b, c, d, e, f, 2 more')
    """
    more = len(names) - _LISTED
    return ", ".join([*names[:_LISTED], f"{more} more"] if more > 0 else names)


def titled(name: str, unit: str) -> str:
    """A quantity's name with its unit, which pure numbers do not have.

    >>> titled("torque", "N·m"), titled("friction", "1"), titled("return", "")
    ('torque [N·m]', 'friction', 'return')
    """
    return name if unit in ("", "1") else f"{name} [{unit}]"


def _behind(unit: str) -> str:
    return f" {unit}" if unit not in ("", "1") else ""


def _short_exponent(text: str) -> str:
    mantissa, mark, exponent = text.partition("e")
    return f"{mantissa}e{int(exponent)}" if mark else text
