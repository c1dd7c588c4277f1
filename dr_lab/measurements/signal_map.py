"""From a topic or column of a file to a channel of the model: name, unit, sign, scale, clock."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

from dr_lab.channel_names import POSITION, VELOCITY, quantity
from dr_lab.errors import ConfigError, DataError, UnknownNameError
from dr_lab.measurements.units import Unit, unit
from dr_lab.trajectory import Array

# One reading is a weighted sum of a file's fields or columns.
Reading = Mapping[str, float]

_UNITS = {POSITION: ("rad", "m"), VELOCITY: ("rad/s", "m/s")}
_EXAMPLES = {POSITION: "rad, deg, m or mm", VELOCITY: "rad/s, deg/s or m/s"}
BETWEEN = ("hold", "line", "unknown")  # what a command does from one sample to the next
_CLOCKS = ("header", "publish", "log", "column")

_NUMBERS = ("scale", "offset", "latency", "noise_std")


@dataclass(frozen=True)
class ChannelMap:
    """Where one channel comes from and how its numbers become SI.

    x = factor(unit) · (sign · scale · Σ_j w_j raw_j + offset), with the weights w_j of the reading (one field or
    column of weight 1 as a rule).

    Attributes:
        name: channel of the model.
        unit: unit of the numbers after sign, scale and offset.
        topic: MCAP topic, or ``""`` for a table.
        readings: one per component of a vector channel, a single one for a scalar.
        vector: whether the channel's samples have shape (n, k) instead of (n,).
        sign: +1 or −1.
        scale: factor into `unit`.
        offset: in `unit`.
        noise_std: known standard deviation of the noise in `unit`, or None to estimate it.
        wrap: rad or m by which the numbers jump where they wrap; 0 if they do not.
        clock: whose stamps to use, ``header``, ``publish``, ``log`` or ``column``; ``""`` takes that of the file.
        latency: known time in s by which the stamps lie after the true times; it is subtracted.
        between: of commands, ``hold``, ``line`` or ``unknown``, see `Signal.between`; ``""`` leaves it to the motion.
    """

    name: str
    unit: Unit
    topic: str
    readings: tuple[Reading, ...]
    vector: bool
    sign: float = 1.0
    scale: float = 1.0
    offset: float = 0.0
    noise_std: float | None = None
    wrap: float = 0.0
    clock: str = ""
    latency: float = 0.0
    between: str = ""

    def to_si(self, raw: Array) -> Array:
        """Convert raw numbers of any shape to the channel's SI unit."""
        return self.unit.factor * (self.sign * self.scale * raw + self.offset)

    @property
    def noise_std_si(self) -> float | None:
        """Known noise in the SI unit, or None."""
        return None if self.noise_std is None else self.unit.factor * self.noise_std

    @property
    def source(self) -> str:
        """What the user wrote, for messages."""
        parts = "; ".join(
            " + ".join(f"{w:g}·{name}" if w != 1 else name for name, w in r.items()) for r in self.readings
        )
        return f"topic {self.topic} {parts}" if self.topic else f"column {parts}"


def channel_map(name: str, settings: Mapping[str, Any], clock: str) -> ChannelMap:
    """Read one entry of a ``measurements`` configuration.

    Args:
        name: channel of the model.
        settings: ``unit``, then ``topic`` and ``field`` (MCAP) or ``column`` (CSV, Parquet), and any of the further
            attributes of `ChannelMap`. A field or column is a name, a mapping from names to weights (their weighted
            sum), or a list of either (a vector channel).
        clock: the clock if the entry names none; ``""`` leaves the choice to the file.

    Raises:
        ConfigError: a key is missing or contradicts another.
        UnknownNameError: a key or clock that does not exist.
        DataError: unknown unit, or one of the wrong dimension.
    """
    _check_keys(name, settings)
    place = settings.get("field", settings.get("column"))
    vector = isinstance(place, Sequence) and not isinstance(place, str)
    readings = tuple(_reading(name, part) for part in (place if vector else (place,)))  # pyright: ignore[reportOptionalIterable]
    chosen = str(settings.get("clock") or clock or "")
    if chosen and chosen not in _CLOCKS:
        raise UnknownNameError("clock", chosen, _CLOCKS, f"the entry of channel {name!r}")
    measured = _unit(name, str(settings["unit"]))
    numbers = {key: _number(name, key, settings[key]) for key in _NUMBERS if settings.get(key) is not None}
    return ChannelMap(
        name=name,
        unit=measured,
        topic=str(settings.get("topic", "")),
        readings=readings,
        vector=vector,
        sign=_sign(name, settings.get("sign", 1)),
        wrap=_wrap(name, settings.get("wrap", False), measured.factor),
        clock=chosen,
        between=_between(name, settings.get("between")),
        **numbers,
    )


def channel_maps(entries: Mapping[str, Mapping[str, Any]], clock: str) -> tuple[ChannelMap, ...]:
    """Read all entries of ``outputs`` or ``commands``; see `channel_map`."""
    return tuple(channel_map(name, settings, clock) for name, settings in entries.items())


def _check_keys(name: str, settings: Mapping[str, Any]) -> None:
    if not isinstance(settings, Mapping):
        raise ConfigError(
            f"Channel {name!r} is {settings!r}; expected its entry, e.g. {{column: NAME, unit: rad}} or "
            "{topic: NAME, field: PATH, unit: rad}. To leave the channel out, remove it: ~measurements.outputs.…"
        )
    known = {f.name for f in fields(ChannelMap)} - {"name", "readings", "vector"} | {"field", "column"}
    for key in settings:
        if key not in known:
            raise UnknownNameError("key", str(key), known, f"the entry of channel {name!r}")
    given = {key for key in ("topic", "field", "column") if settings.get(key) not in (None, "", [], {})}
    if given not in ({"topic", "field"}, {"column"}):
        expected = "topic and field (MCAP) or column (CSV, Parquet)"
        raise ConfigError(f"Channel {name!r}: give {expected}; got {', '.join(sorted(given)) or 'neither'}.")
    if not settings.get("unit"):
        raise ConfigError(f"Channel {name!r}: give its unit, e.g. unit: rad (1 for a number without one).")


def _reading(name: str, part: object) -> Reading:
    if isinstance(part, str):
        return {part: 1.0}
    if isinstance(part, Mapping) and part and all(isinstance(w, int | float) for w in part.values()):
        return {str(key): float(weight) for key, weight in part.items()}
    raise ConfigError(f"Channel {name!r}: {part!r} is neither a name nor a mapping from names to weights.")


def _unit(name: str, text: str) -> Unit:
    found, measured = unit(text), quantity(name)
    if measured and found.name not in _UNITS[measured]:
        raise DataError(
            f"Channel {name!r}: unit {text!r} has dimension {found.dimension}; a joint's {measured} is measured in "
            f"{_EXAMPLES[measured]}. Correct unit or the channel's name. Of counts give the angle or way of one in "
            "scale, and its unit."
        )
    if text == "g":
        raise DataError(
            f"Channel {name!r}: unit 'g' is the gram. Write g_0 for an acceleration in standard gravities, or gram."
        )
    return found


def _wrap(name: str, value: object, factor: float) -> float:
    """The jump of a channel that wraps, in SI: a full turn, or so much in the channel's unit."""
    if isinstance(value, bool):
        return 2 * math.pi * value
    if not isinstance(value, int | float) or not 0 < value < math.inf:
        raise ConfigError(
            f"Channel {name!r}: wrap is {value!r}; expected true for an angle that jumps by a full turn, or the jump "
            "as a number above 0 in the channel's unit, after its scale."
        )
    return float(value) * factor


def _sign(name: str, value: object) -> float:
    if value not in (1, -1):
        raise ConfigError(f"Channel {name!r}: sign must be 1 or -1; got {value!r}. Put other factors into scale.")
    return float(value)  # pyright: ignore[reportArgumentType]


def _between(name: str, given: object) -> str:
    if given not in (None, "", *BETWEEN):
        raise UnknownNameError("way between samples", str(given), BETWEEN, f"the entry of channel {name!r}")
    return str(given or "")


def _number(name: str, key: str, value: object) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
        raise ConfigError(f"Channel {name!r}: {key} is {value!r}; expected a number.")
    if key == "scale" and value == 0:
        raise ConfigError(f"Channel {name!r}: scale is 0, which leaves nothing of its numbers; give another.")
    if key == "noise_std" and value <= 0:
        raise ConfigError(f"Channel {name!r}: noise_std must be > 0; got {value!r}. Write null to estimate it.")
    return float(value)


def names_of(readings: Iterable[Reading]) -> tuple[str, ...]:
    """All fields or columns that the readings need, each once."""
    return tuple(dict.fromkeys(name for reading in readings for name in reading))
