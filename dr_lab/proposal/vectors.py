"""Series that are the components of one vector or quaternion, by their names and numbers."""

import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from dr_lab.proposal.survey import Series
from dr_lab.proposal.tokens import tokens
from dr_lab.trajectory import Array

VectorKind = Literal["position", "orientation", "rate", "acceleration"]

_AXIS = re.compile(r"([a-z]*)([wxyz])")
_UNIT_NORM = 0.02  # by which the norms of quaternions may be off in the middle half of the samples
_UNITS: dict[str, VectorKind] = {
    "rad/s": "rate",
    "deg/s": "rate",
    "m/s^2": "acceleration",
    "m": "position",
    "mm": "position",
}
_SAID: dict[VectorKind, frozenset[str]] = {
    "rate": frozenset({"gyro", "gyr", "gyroscope", "g", "omega", "w", "angular"}),
    "acceleration": frozenset({"accelerometer", "acceleration", "accel", "acc", "a"}),
    "position": frozenset({"position", "pos", "p", "translation", "location"}),
}
_NO_POSITION = frozenset({"v", "vel", "velocity", "linear", "mag", "magnetometer", "force", "torque", "f", "error"})


@dataclass(frozen=True)
class Vector:
    """Some series side by side.

    Attributes:
        kind: what it is of a body: its position, its orientation as a quaternion, its angular rate or what an
            accelerometer reads.
        parts: x, y, z, or w, x, y, z, or some of the first three.
        axes: of the parts, one letter each.
    """

    kind: VectorKind
    parts: tuple[Series, ...]
    axes: str

    @property
    def unit(self) -> str:
        """What the names say; empty where they do not."""
        units = {each.words.unit for each in self.parts}
        return units.pop() if len(units) == 1 else ""

    def log(self, k: int) -> tuple[Array, Array]:
        """Times of the first component in the k-th log, and all components at these times, shape (n, parts)."""
        time = self.parts[0].signals[k].time
        columns = [np.interp(time, each.signals[k].time, each.signals[k].value) for each in self.parts]
        return time, np.stack(columns, axis=-1)


def find_vectors(series: Sequence[Series]) -> list[Vector]:
    """All vectors among some series: names that differ in an axis alone, such as ``gx``, ``pose.position.x``."""
    found = []
    for key, parts in _groups(series).items():
        axes = "wxyz" if {*parts} == {*"wxyz"} else "xyz"
        if {*axes} <= {*parts}:
            vector = tuple(parts[axis] for axis in axes)
            kind = _orientation(vector) if axes == "wxyz" else _kind_of(key, vector)
            found += [Vector(kind, vector, axes)] if kind else []
    return found


def find_parts(series: Sequence[Series]) -> list[Vector]:
    """One or two axes of vectors, whose others nobody logged: ``x`` and ``y`` of what a camera sees."""
    found = []
    for key, parts in _groups(series).items():
        axes = "".join(sorted(parts))
        if len(axes) < 3 and "w" not in axes:
            vector = tuple(parts[axis] for axis in axes)
            kind = _kind_of(key, vector)
            found += [Vector(kind, vector, axes)] if kind else []
    return found


def _groups(series: Sequence[Series]) -> dict[tuple[str, ...], dict[str, Series]]:
    """Series by axis, by their topic and what their names have in common."""
    groups: dict[tuple[str, ...], dict[str, Series]] = defaultdict(dict)
    for each in series:
        words = tokens(each.place.path)
        for k, word in enumerate(words):
            if (axis := _AXIS.fullmatch(word)) and not each.words.asked:
                groups[each.place.topic, *words[:k], axis[1], "*", *words[k + 1 :]].setdefault(axis[2], each)
    return groups


def _kind_of(key: tuple[str, ...], parts: Sequence[Series]) -> VectorKind | Literal[""]:
    return _kind({*key[1:]}, {*tokens(key[0])}, parts[0].words.unit)


def _orientation(parts: Sequence[Series]) -> Literal["orientation", ""]:
    """Quaternions have the norm 1."""
    norms = np.concatenate(
        [np.linalg.norm(Vector("orientation", (*parts,), "wxyz").log(k)[1], axis=1) for k in range(_logs(parts))]
    )
    low, high = np.quantile(norms, (0.25, 0.75))
    return "orientation" if max(abs(low - 1.0), abs(high - 1.0)) < _UNIT_NORM else ""


def _logs(parts: Sequence[Series]) -> int:
    return len(parts[0].signals)


def _kind(own: set[str], above: set[str], unit: str) -> VectorKind | Literal[""]:
    """By the unit, else by the name's own words, else by the topic's; bare x, y, z are a position."""
    if unit:
        return _UNITS.get(unit, "")
    for said in (own, above):
        for kind, words in _SAID.items():
            if said & words and not (kind == "position" and said & _NO_POSITION):
                return kind
        if said & _NO_POSITION:
            return ""
    return "position" if own <= {"", "*"} else ""
