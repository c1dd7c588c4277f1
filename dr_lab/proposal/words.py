"""What a topic, field or column is, by its name alone: which quantity, in which unit, of which joint."""

import itertools
import re
from collections import defaultdict
from collections.abc import Collection, Iterable
from dataclasses import dataclass

from dr_lab.proposal.tokens import tokens
from dr_lab.proposal.vocabulary import (
    ALONE,
    AXES,
    DRIVE,
    ELECTRIC,
    LETTERS,
    MEASURED,
    OTHER,
    POSITION,
    PRESENT,
    REFERENCE,
    SUPPLY,
    TORQUE_CURRENT,
    UNITS,
    UNTELLING,
    VELOCITY,
    Kind,
)

_NUMBERED = re.compile(r"(?<![A-Za-z])[A-Za-z]\d+$")


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
        if len(last) == 1 and last.isalpha() and {*before} & POSITION:
            letters[tuple(before)].add(last)
    return frozenset(before for before, found in letters.items() if found - LETTERS.keys() - AXES)


def asked_for(paths: Iterable[str]) -> frozenset[tuple[str, ...]]:
    """What is asked for: the words of such names without those that say so, ``j 1`` of J1_des.

    Args:
        paths: fields or columns.
    """
    every = [tokens(path) for path in paths]
    return frozenset(tuple(word for word in words if word not in REFERENCE) for words in every if {*words} & REFERENCE)


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
    unit, unit_kind, rest = _unit(own, apart, numbered=bool(_NUMBERED.search(place)))
    above = set(tokens(topic))
    asked = bool({*rest} & REFERENCE or (above & REFERENCE and not (above | {*rest}) & MEASURED))
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
    if TORQUE_CURRENT in itertools.pairwise(words):
        return "A"
    return next((unit for word, unit in ELECTRIC.items() if word in words), "")


def identity(name: str) -> frozenset[str]:
    """The words of a joint's or actuator's name that tell it from others."""
    words = frozenset(tokens(name)) - {"joint", "link", "motor", "actuator", "act"}
    return words or frozenset(tokens(name))


def _kind(rest: list[str], above: set[str], by_unit: Kind, asked: bool) -> Kind:
    bare = [_bare(word) for word in rest]
    own = {*bare, *({"current"} if TORQUE_CURRENT in itertools.pairwise(bare) else ())}
    said = own | above
    weighed = by_unit == "drive" and "load" in own and not own & DRIVE  # a load in N is a load cell's
    if own & OTHER or by_unit == "other" or weighed or SUPPLY.search("".join(rest)):
        return "other"
    if by_unit == "velocity" or own & VELOCITY or any(word.startswith("d") and word[1:] in POSITION for word in own):
        return "asked velocity" if asked else "velocity"
    drives = {word for word in own & (DRIVE - {"u", "motor"}) if not own & PRESENT.get(word, set())}
    if by_unit == "drive" or (drives - PRESENT.keys() if by_unit == "position" else drives):
        return "drive"
    if asked:
        return "drive" if above & (DRIVE - {"u", "motor"}) else "reference"
    if by_unit == "position" or own & POSITION:
        return "position"
    return "drive" if said & DRIVE else ""


def _bare(word: str) -> str:
    return word.rstrip("0123456789")


def _unnumbered(words: list[str]) -> list[str]:
    """The words of a name without the numbers at its end."""
    rest = list(words)
    while rest and rest[-1].isdigit() and len(rest) > 1 and not _ends(rest):
        rest = rest[:-1]
    return rest


def _unit(words: list[str], apart: Collection[tuple[str, ...]], *, numbered: bool) -> tuple[str, Kind, list[str]]:
    """Unit at the end of a name, before an index in brackets; what it says; the words before it.

    A single letter with a number of its own, as in pos_m3, is no unit.
    """
    rest = _unnumbered(words)
    for ending, unit, kind in UNITS:
        before = rest[: -len(ending)]
        if len("".join(ending)) == 1 and (numbered or tuple(before) in apart):
            continue
        whole = rest == [*ending] and {*ending} <= ALONE
        if (before or whole) and tuple(rest[-len(ending) :]) == ending and _may_be(ending, kind, before):
            return unit, kind, before + words[len(rest) :]
    return "", "", words


def _may_be(ending: tuple[str, ...], kind: Kind, before: list[str]) -> bool:
    """Whether an ending may be a unit: a single letter behind words of another quantity tells one joint from others.

    Axes are called as positions are, so that a force along x may be in N.
    """
    measured = LETTERS.get("".join(ending))
    if measured is None:
        return True
    words = {*before} - {"motor"}
    said = _kind([*words], set(), "", asked=False)
    return said in ("", "other") or (said in ("position", kind) and bool(words & measured))


def _ends(words: list[str]) -> bool:
    return any(len(words) > len(ending) and tuple(words[-len(ending) :]) == ending for ending, _, _ in UNITS)


def _names(word: str) -> bool:
    return not word.isdigit() and word not in UNTELLING
