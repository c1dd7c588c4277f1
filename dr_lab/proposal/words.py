"""What a topic, field or column is, by its name alone: which quantity, in which unit, of which joint."""

import itertools
import re
from collections import defaultdict
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Literal

from dr_lab.proposal.tokens import tokens

Kind = Literal["position", "velocity", "drive", "reference", "asked velocity", "other", ""]

# Units as the last words of a name, the longest first, with the quantity that they say.
_UNITS: tuple[tuple[tuple[str, ...], str, Kind], ...] = (
    (("rad", "per", "s"), "rad/s", "velocity"),
    (("deg", "per", "s"), "deg/s", "velocity"),
    (("rad", "s", "2"), "rad/s^2", "other"),
    (("m", "s", "2"), "m/s^2", "other"),
    (("rad", "s"), "rad/s", "velocity"),
    (("mrad", "s"), "mrad/s", "velocity"),
    (("rads",), "rad/s", "velocity"),
    (("deg", "s"), "deg/s", "velocity"),
    (("mm", "s"), "mm/s", "velocity"),
    (("m", "s"), "m/s", "velocity"),
    (("radps",), "rad/s", "velocity"),
    (("dps",), "deg/s", "velocity"),
    (("mmps",), "mm/s", "velocity"),
    (("mps",), "m/s", "velocity"),
    (("rpm",), "rpm", "velocity"),
    (("1", "min"), "rpm", "velocity"),
    (("u", "min"), "rpm", "velocity"),
    (("rev", "min"), "rpm", "velocity"),
    (("m", "nm"), "mN·m", "drive"),
    (("mnm",), "mN·m", "drive"),
    (("n", "m"), "N·m", "drive"),
    (("nm",), "N·m", "drive"),
    (("newton",), "N", "drive"),
    (("mv",), "mV", "drive"),
    (("m", "v"), "mV", "drive"),
    (("volt",), "V", "drive"),
    (("volts",), "V", "drive"),
    (("v",), "V", "drive"),
    (("ma",), "mA", "drive"),
    (("m", "a"), "mA", "drive"),
    (("amp",), "A", "drive"),
    (("a",), "A", "drive"),
    (("n",), "N", "drive"),
    (("rad",), "rad", "position"),
    (("mrad",), "mrad", "position"),
    (("deg",), "deg", "position"),
    (("degrees",), "deg", "position"),
    (("turn",), "turn", "position"),
    (("turns",), "turn", "position"),
    (("rev",), "turn", "position"),
    (("um",), "um", "position"),
    (("mm",), "mm", "position"),
    (("cm",), "cm", "position"),
    (("m",), "m", "position"),
)
_ALONE = {"rpm", "dps", "mps", "mmps", "radps", "rads", "deg", "degrees", "rad", "mrad"}  # units that are a whole name
_VELOCITY = {
    *("vel", "vels", "velocity", "velocities", "dot", "qd", "dq", "qvel", "speed", "omega", "rate"),
    *("drehzahl", "geschwindigkeit", "velocidad", "vitesse"),
}
_SUPPLY = re.compile(r"dc(bus|link)|[uv](bus|batt?|dc)(?![a-z])")  # of words without what is between them: DCbus, Vbat
_OTHER = {
    *("acc", "accel", "acceleration", "accelerations", "qdd", "ddq", "error", "errors", "temperature", "temp"),
    *("cell", "loadcell", "bus", "battery", "supply", "mains"),  # forces and voltages that drive nothing
    *("index", "frame", "count", "id", "episode", "task", "done", "reward", "time", "timestamp", "stamp", "seq"),
}
_REFERENCE = {
    *("ref", "reference", "des", "desired", "target", "goal", "setpoint", "cmd", "command", "commands", "commanded"),
    *("action", "ctrl", "control", "controls", "con", "input", "set", "soll", "sollwert", "demand", "demanded"),
}
_MEASURED = {"state", "states", "feedback", "actual", "meas", "measured", "ist", "istwert"}
_DRIVE = {
    *("tau", "taus", "torque", "torques", "effort", "efforts", "force", "forces", "voltage", "duty", "pwm", "current"),
    *("u", "motor", "act", "strom", "spannung", "drehmoment", "moment", "kraft"),
    *("corriente", "voltaje", "courant"),
}
_POSITION = {
    *("pos", "position", "positions", "q", "qpos", "angle", "angles", "theta", "phi", "psi", "alpha", "beta", "state"),
    *("x", "y", "z", "enc", "encoder", "encoders", "joints", "winkel", "weg", "angulo", "posicion"),
}
# Words of drives that are also said of what is measured, with the words they then go with: pos_act, current position.
_PRESENT: dict[str, set[str]] = {
    "act": _POSITION - {"x", "y", "z", "state", "joints"},
    "current": {"pos", "position", "positions", "qpos", "angle", "angles"},
}
_ELECTRIC = {"current": "A", "voltage": "V", "strom": "A", "spannung": "V"}
_TORQUE_CURRENT = ("i", "q")  # of a motor that is driven by field orientation
# Single letters that are units, with the words of quantities that are measured in them.
_LETTERS: dict[str, set[str]] = {
    "a": {"current", "strom", "i", "u"},
    "v": {"voltage", "spannung", "pwm", "u"},
    "n": {"force", "forces", "kraft", "effort", "efforts", "u"},
    "m": _POSITION - {"angle", "angles", "theta", "phi", "psi", "alpha", "beta"},
}

_AXES = {"x", "y", "z"}
_GENERIC = {
    *(
        "joint",
        "joints",
        "link",
        "meas",
        "measured",
        "actual",
        "observation",
        "raw",
        "est",
        "estimated",
        "data",
        "main",
    ),
    *("j", "states", "feedback", "applied", "per", "s", "values", "controller", "position", "velocity", "group"),
}
_UNTELLING = (
    _GENERIC
    | _VELOCITY
    | _REFERENCE
    | _OTHER
    | _DRIVE
    | _MEASURED
    | {"pos", "positions", "q", "qpos", "angle", "winkel", "weg", "angulo", "posicion", "°"}
)


@dataclass(frozen=True)
class Words:
    """What a name says.

    Attributes:
        kind: the quantity; ``drive`` is a force, torque, voltage or current, ``reference`` what is asked for, whatever
            its quantity, unless that is a velocity (``asked velocity``); empty where the name does not say.
        unit: empty where the name does not say.
        asked: whether it is said to be asked for rather than measured.
        identity: words that may be those of a joint or actuator.
        number: the only number in the name, or None.
    """

    kind: Kind
    unit: str
    asked: bool
    identity: frozenset[str]
    number: int | None


def told_apart(paths: Iterable[str]) -> frozenset[tuple[str, ...]]:
    """Words of positions behind which several single letters follow, one of which is no unit: ``q`` of q_m and q_l.

    Args:
        paths: fields or columns.
    """
    letters = defaultdict[tuple[str, ...], set[str]](set)
    for path in paths:
        *before, last = _unnumbered(tokens(path)) or [""]
        if len(last) == 1 and last.isalpha() and {*before} & _POSITION:
            letters[tuple(before)].add(last)
    return frozenset(before for before, found in letters.items() if found - _LETTERS.keys() - _AXES)


def asked_for(paths: Iterable[str]) -> frozenset[tuple[str, ...]]:
    """What is asked for: the words of such names without those that say so, ``j 1`` of J1_des.

    Args:
        paths: fields or columns.
    """
    every = [tokens(path) for path in paths]
    return frozenset(
        tuple(word for word in words if word not in _REFERENCE) for words in every if {*words} & _REFERENCE
    )


def read_name(
    topic: str,
    path: str,
    label: str,
    apart: Collection[tuple[str, ...]] = (),
    asked_for: Collection[tuple[str, ...]] = (),
) -> Words:
    """Read the name of a series.

    Args:
        topic: of its messages; empty for a table.
        path: field or column.
        label: of a list's entry; empty where it has none.
        apart: words behind which a single letter is no unit, from `told_apart`.
        asked_for: from `asked_for`; ``act`` beside such words is what there is, as in J1_act beside J1_des.
    """
    place, words = path.replace(f"[{label}]", "") if label else path, tokens(label)
    own = tokens(place)
    without = [word for word in own if word != "act"]
    own = without if tuple(without) in asked_for else own
    unit, unit_kind, rest = _unit(own, apart)
    above = set(tokens(topic))
    asked = bool({*rest} & _REFERENCE or (above & _REFERENCE and not (above | {*rest}) & _MEASURED))
    numbers = [int(word) for word in (words or rest) if word.isdigit()]
    identity = frozenset(word for word in (*words, *rest) if _names(word))
    return Words(_kind(rest, above, unit_kind, asked), unit, asked, identity, numbers[-1] if numbers else None)


def electric_unit(path: str, base: str) -> str:
    """The unit of a current or voltage that commands a force and whose name says no unit; empty of everything else.

    Args:
        path: field or column of a drive.
        base: SI unit of what it commands.
    """
    if base not in ("N·m", "N"):
        return ""
    words = [_bare(word) for word in tokens(path)]
    if _TORQUE_CURRENT in itertools.pairwise(words):
        return "A"
    return next((unit for word, unit in _ELECTRIC.items() if word in words), "")


def identity(name: str) -> frozenset[str]:
    """The words of a joint's or actuator's name that tell it from others."""
    words = frozenset(tokens(name)) - {"joint", "link", "motor", "actuator", "act"}
    return words or frozenset(tokens(name))


def _kind(rest: list[str], above: set[str], by_unit: Kind, asked: bool) -> Kind:
    bare = [_bare(word) for word in rest]
    own = {*bare, *({"current"} if _TORQUE_CURRENT in itertools.pairwise(bare) else ())}
    said = own | above
    weighed = by_unit == "drive" and "load" in own and not own & _DRIVE  # a load in N is a load cell's
    if own & _OTHER or by_unit == "other" or weighed or _SUPPLY.search("".join(rest)):
        return "other"
    if by_unit == "velocity" or own & _VELOCITY or any(word.startswith("d") and word[1:] in _POSITION for word in own):
        return "asked velocity" if asked else "velocity"
    drives = {word for word in own & (_DRIVE - {"u", "motor"}) if not own & _PRESENT.get(word, set())}
    if by_unit == "drive" or (drives - _PRESENT.keys() if by_unit == "position" else drives):
        return "drive"
    if asked:
        return "drive" if above & (_DRIVE - {"u", "motor"}) else "reference"
    if by_unit == "position" or own & _POSITION:
        return "position"
    return "drive" if said & _DRIVE else ""


def _bare(word: str) -> str:
    return word.rstrip("0123456789")


def _unnumbered(words: list[str]) -> list[str]:
    """The words of a name without the numbers at its end."""
    rest = list(words)
    while rest and rest[-1].isdigit() and len(rest) > 1 and not _ends(rest):
        rest = rest[:-1]
    return rest


def _unit(words: list[str], apart: Collection[tuple[str, ...]]) -> tuple[str, Kind, list[str]]:
    """Unit at the end of a name, before an index in brackets; what it says; the words before it."""
    rest = _unnumbered(words)
    for ending, unit, kind in _UNITS:
        before = rest[: -len(ending)]
        if len("".join(ending)) == 1 and tuple(before) in apart:
            continue
        whole = rest == [*ending] and {*ending} <= _ALONE
        if (before or whole) and tuple(rest[-len(ending) :]) == ending and _may_be(ending, kind, before):
            return unit, kind, before + words[len(rest) :]
    return "", "", words


def _may_be(ending: tuple[str, ...], kind: Kind, before: list[str]) -> bool:
    """Whether an ending may be a unit: a single letter behind words of another quantity tells one joint from others.

    Axes are called as positions are, so that a force along x may be in N.
    """
    measured = _LETTERS.get("".join(ending))
    if measured is None:
        return True
    words = {*before} - {"motor"}
    said = _kind([*words], set(), "", asked=False)
    return said in ("", "other") or (said in ("position", kind) and bool(words & measured))


def _ends(words: list[str]) -> bool:
    return any(len(words) > len(ending) and tuple(words[-len(ending) :]) == ending for ending, _, _ in _UNITS)


def _names(word: str) -> bool:
    return not word.isdigit() and word not in _UNTELLING
