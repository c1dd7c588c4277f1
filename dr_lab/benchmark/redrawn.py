"""Listed cases drawn again: other sizes, other noise, other seeds, so that nobody has looked at them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from dr_lab.benchmark.case import BenchmarkMachine, Case
from dr_lab.benchmark.listed import Listed
from dr_lab.errors import ConfigError
from dr_lab.seeding import derived_seed, stream


@dataclass(frozen=True)
class Redrawn(Listed):
    """The entries of a list, each with a size, instruments and a seed of its own drawing.

    One factor f is drawn for each hidden effect, log f uniform in [-log spread, log spread]. A number x becomes f x.
    A share of what is documented, which is 1 where nothing is hidden, becomes x**f. Numbers that count or choose
    something stay. The drawing of an entry depends on `draw` and on its name alone, so that a choice of cases does
    not change them.

    Attributes:
        draw: number of the drawing; each has cases that no other has.
        spread: largest factor of a size.
        shares: numbers that are 1 where nothing is hidden, as ``option.number``.
        kept: numbers that are not drawn, as ``option.number``.
        noises: options of ``plant/instruments`` to draw from, for entries that have one of them.

    Raises:
        ConfigError: `spread` is below 1, or there is no instrument to draw.
    """

    draw: int
    spread: float
    shares: Sequence[str]
    kept: Sequence[str]
    noises: Sequence[str]

    def __post_init__(self) -> None:
        if self.spread < 1:
            raise ConfigError(f"spread is {self.spread}; expected 1 or more: the largest factor of a hidden size.")
        if not self.noises:
            raise ConfigError("noises is empty; expected one option of plant/instruments or more, such as [white].")

    def cases(self, set_name: str, machines: Mapping[str, BenchmarkMachine]) -> Iterator[Case]:
        """The cases of the machines that were chosen; a name ends in the number of the drawing."""
        drawn = {f"{name}_draw_{self.draw}": self._again(name, fields) for name, fields in self.entries.items()}
        for case in Listed(self.kind, drawn).cases(set_name, machines):
            yield replace(case, seed=derived_seed(self.draw, case.name))

    def _again(self, name: str, fields: Mapping[str, Any]) -> dict[str, Any]:
        rng = stream(self.draw, "redrawn", name)
        hide = {label: self._sized(label, numbers, rng) for label, numbers in fields.get("hide", {}).items()}
        noise = str(rng.choice(list(self.noises)))
        drawn = {"instruments": noise} if fields.get("instruments") in self.noises else {}
        return {**fields, "hide": hide, **drawn}

    def _sized(self, label: str, numbers: Mapping[str, Any], rng: np.random.Generator) -> dict[str, Any]:
        option, _, _ = label.partition("@")
        factor = float(self.spread ** rng.uniform(-1, 1))
        return {key: self._value(f"{option}.{key}", value, factor) for key, value in numbers.items()}

    def _value(self, name: str, value: object, factor: float) -> object:
        if isinstance(value, list | tuple):
            return [self._value(name, part, factor) for part in value]
        if name in self.kept or not isinstance(value, float):
            return value
        return float(f"{value**factor if name in self.shares else value * factor:.4g}")
