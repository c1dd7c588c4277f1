"""What is wrong with commands and what to write instead, in words."""

import math
import re
from collections.abc import Sequence

import numpy as np

# True unit's size in that of the number that is read: a command of so many of these per SI unit was called SI.
_UNITS = {
    "milli (mN·m called N·m, mV called V)": 1e-3,
    "kilo (N·m called mN·m)": 1e3,
    "degrees (deg called rad)": np.pi / 180,
    "radians (rad called deg)": 180 / np.pi,
    "kilogram-force (kgf called N)": 9.80665,
    "kilogram-force centimetres (kgf·cm called N·m)": 0.0980665,
    "newton (N called kgf)": 1 / 9.80665,
    "centi (cm called m, per cent called 1)": 1e-2,
    "hundreds (1 called per cent)": 1e2,
    "revolutions (rev called rad)": 2 * np.pi,
}

_STRETCH = re.compile(r"(?P<log>.*)\[(?P<start>[^\[\]:]*):(?P<stop>[^\[\]:]*)\]")  # as in measurements.fit


def factor_words(gain: float, near: float) -> str:
    """The known factor that a gain is off from by a ratio of at most `near`, as a clause; empty where there is none."""
    name, factor = min(_UNITS.items(), key=lambda entry: abs(np.log(abs(gain) / entry[1])))
    sign = " and of the opposite sign" if gain < 0 else ""
    if abs(np.log(abs(gain) / factor)) > np.log(near):
        return sign
    return f", near {factor:.4g}: {name}{sign}"


def remedy_of_factor(actuator: str, gain: float) -> str:
    """What to write in the measurements."""
    turned = f" {remedy_of_sign(actuator)}" if gain < 0 else ""
    return (
        f"Write the unit that measurements.commands.{actuator} has (mN·m, deg …), or its scale; or correct the "
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
