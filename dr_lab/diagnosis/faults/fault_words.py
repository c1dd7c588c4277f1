"""What is wrong with commands and what to write instead, in words."""

import itertools
import math
import re
from collections.abc import Mapping, Sequence

import numpy as np

# What a command of a unit may be in truth: words, and the true unit's size in that of the number that is read.
_UNITS: Mapping[str, Mapping[str, float]] = {
    "N·m": {
        "milli (mN·m called N·m)": 1e-3,
        "kilo (N·m called mN·m)": 1e3,
        "kilogram-force metres (kgf·m called N·m)": 9.80665,
        "newton metres (N·m called kgf·m)": 1 / 9.80665,
        "kilogram-force centimetres (kgf·cm called N·m)": 0.0980665,
        "newton metres (N·m called kgf·cm)": 1 / 0.0980665,
    },
    "N": {
        "milli (mN called N)": 1e-3,
        "kilo (N called mN, kN called N)": 1e3,
        "kilogram-force (kgf called N)": 9.80665,
        "newton (N called kgf)": 1 / 9.80665,
    },
    "V": {"milli (mV called V)": 1e-3, "kilo (V called mV)": 1e3},
    "m": {"milli (mm called m)": 1e-3, "kilo (m called mm)": 1e3, "centi (cm called m)": 1e-2},
    "rad": {
        "degrees (deg called rad)": np.pi / 180,
        "radians (rad called deg)": 180 / np.pi,
        "revolutions (rev called rad)": 2 * np.pi,
    },
    "1": {"per cent (per cent called 1)": 1e-2, "hundreds (1 called per cent)": 1e2},
}

# What positions and velocities of an SI unit are mistaken for: the true unit, what it is called, true over read number.
_DEGREE = np.pi / 180
_SIZES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
_LENGTHS = tuple((a, b, _SIZES[a] / _SIZES[b]) for a, b in itertools.permutations(_SIZES, 2))
_ANGLES = (("deg", "rad", _DEGREE), ("rad", "deg", 1 / _DEGREE))
_OUTPUTS = {"m": _LENGTHS, "rad": _ANGLES}
_RPM = np.pi / 30
_RATES = (("rpm", "rad/s", _RPM), ("rad/s", "rpm", 1 / _RPM), ("rpm", "deg/s", 6.0), ("deg/s", "rpm", 1 / 6.0))

_STRETCH = re.compile(r"(?P<log>.*)\[(?P<start>[^\[\]:]*):(?P<stop>[^\[\]:]*)\]")  # as in measurements.fit


def known_factors(unit: str) -> Mapping[str, float]:
    """What commands of an SI unit may be in truth: words, and the factor that makes the true number of the read one."""
    return _UNITS.get(unit, {})


def factor_words(gain: float, near: float, unit: str) -> str:
    """The known factor that a gain is off from by a ratio of at most `near`, as a clause; empty where there is none.

    Args:
        gain: needed force over the commands'.
        near: ratio.
        unit: SI unit of the command, whose own mistakes go before those of other units.
    """
    sign = " and of the opposite sign" if gain < 0 else ""
    every = {name: factor for known in _UNITS.values() for name, factor in known.items()}
    for known in (known_factors(unit), every):
        name = min(known, key=lambda each: abs(np.log(abs(gain) / known[each])), default="")
        if name and abs(np.log(abs(gain) / known[name])) <= np.log(near):
            return f", near {known[name]:.4g}: {name}{sign}"
    return sign


def position_units(unit: str) -> Sequence[tuple[str, str, float]]:
    """What a joint's channel of an SI unit may be in truth: unit, what it is called, and true over read number."""
    base, _, rest = unit.partition("/")
    per = f"/{rest}" if rest else ""
    return [(f"{true}{per}", f"{called}{per}", factor) for true, called, factor in _OUTPUTS.get(base, ())]


def channel_units(unit: str) -> Sequence[tuple[str, str, float]]:
    """The same of any channel, of a gyroscope or a tachometer, too."""
    return [*position_units(unit), *(_RATES if unit == "rad/s" else ())]


def remedy_of_unit(place: str, true: str, called: str, factor: float) -> str:
    """What to write of a channel that is in another unit, whatever unit is given there.

    Args:
        place: its entry in the measurements.
        true: the unit that it is in.
        called: the unit that it is read in.
        factor: true over read number.
    """
    return f"If its unit in {place} is {called}, write {true}; else multiply its scale by {factor:.4g}."


def misread_position(gain: float, near: float, channel: str, unit: str) -> str:
    """That a joint's positions in another unit would ask for so many times the force; empty where none would.

    Args:
        gain: needed force over the commands'.
        near: ratio up to which a unit's factor may be off from it.
        channel: its name.
        unit: its SI unit.
    """
    for true, called, factor in position_units(unit):
        if abs(np.log(abs(gain) * factor)) <= np.log(near):
            return f" Or {channel} is in {true} and called {called}: write its unit in measurements.outputs."
    return ""


def remedy_of_factor(actuator: str, gain: float) -> str:
    """What to write in the measurements."""
    turned = f" {remedy_of_sign(actuator)}" if gain < 0 else ""
    return (
        f"Write the unit that measurements.commands.{actuator} has (N, mN·m, deg …), or its scale; or correct the "
        f"actuator's gear in the model.{turned}"
    )


def remedy_of_sign(actuator: str) -> str:
    """What to write of commands with the wrong sign, whatever sign is given there."""
    return f"Write sign: -1 in measurements.commands.{actuator}; where it stands there already, delete it."


def parts_outside(log: str, begin: float | None, end: float | None) -> str:
    """Names of the stretches of a log before and behind a span, each to a tenth of a second outside of it.

    Args:
        log: name, maybe of a stretch, e.g. ``log_1[0:3.8]``.
        begin: where the span begins in s; None where too little lies before it.
        end: where it ends in s; None where too little lies behind it.
    """
    match = _STRETCH.fullmatch(log)
    name, start, stop = (match["log"], match["start"], match["stop"]) if match else (log, "", "")
    before = [] if begin is None else [f"{name}[{start}:{math.floor(10 * begin) / 10:g}]"]
    behind = [] if end is None else [f"{name}[{math.ceil(10 * end) / 10:g}:{stop}]"]
    return " and ".join([*before, *behind])


def common_stretch(names: Sequence[str]) -> str:
    """The stretch that stretches of one log have in common, e.g. ``log[0.8:3]`` of ``log[0.8:]`` and ``log[:3]``.

    Empty where they have none.
    """
    found = [match for name in names if (match := _STRETCH.fullmatch(name))]
    start = max((match["start"] for match in found if match["start"]), key=float, default="")
    stop = min((match["stop"] for match in found if match["stop"]), key=float, default="")
    none = start and stop and float(start) >= float(stop)
    return "" if none else f"{found[0]['log']}[{start}:{stop}]"
