"""By what the answers of a benchmark are scored."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from dr_lab.effects.effect import Effect

Aliases = Mapping[str, Mapping[str, str]]
"""Effect → the plant's name of a parameter → the catalogue's, where they differ."""


@dataclass(frozen=True)
class Goals:
    """What the figures should reach; each by its name in the report.

    Attributes:
        at_least: lower limits.
        at_most: upper limits.
    """

    at_least: Mapping[str, float]
    at_most: Mapping[str, float]

    def of(self, name: str) -> str:
        """The goal of a figure, in words; empty where there is none."""
        if name in self.at_least:
            return f"≥ {self.at_least[name]:g}"
        return f"≤ {self.at_most[name]:g}" if name in self.at_most else ""

    def met(self, name: str, value: float | None) -> bool | None:
        """Whether a figure reaches its goal; None where either is missing."""
        if value is None or not self.of(name):
            return None
        return self.at_least.get(name, -np.inf) <= value <= self.at_most.get(name, np.inf)


@dataclass(frozen=True)
class Scoring:
    """By what answers are scored.

    Attributes:
        goals: what the figures should reach.
        parameter_aliases: names of the plants' numbers in the catalogue.
        effects: the catalogue, for the order of the confusion matrix.
    """

    goals: Goals
    parameter_aliases: Aliases
    effects: Mapping[str, Effect]
