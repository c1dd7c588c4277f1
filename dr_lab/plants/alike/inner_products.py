"""Inner products of what signatures make of residuals, as far as regressions on one choice at a time ask for them."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.trajectory import Array


@dataclass(frozen=True)
class InnerProducts:
    """Those of common columns with all, and of each choice's own; two choices are never in one regression.

    Attributes:
        common: of the common columns, shape (p, p).
        across: of these with the choices' columns, all side by side, shape (p, m).
        within: of each choice's columns, of shape (g, g).
    """

    common: Array
    across: Array
    within: tuple[Array, ...]

    @classmethod
    def of(cls, rows: Array, common: int, sizes: Sequence[int]) -> "InnerProducts":
        """The inner products of columns.

        Args:
            rows: the common columns, then the choices', shape (samples, p + m).
            common: p.
            sizes: numbers of columns of the choices, m together.
        """
        first, rest = rows[:, :common], rows[:, common:]
        ends = np.cumsum([0, *sizes])
        within: list[Array] = [np.zeros((0, 0))] * len(sizes)
        for size in set(sizes):
            alike = np.flatnonzero(np.asarray(sizes) == size)
            columns = rest[:, ends[alike, None] + np.arange(size)].transpose(1, 2, 0)
            for number, found in zip(alike, columns @ columns.transpose(0, 2, 1), strict=True):
                within[number] = found
        return cls(first.T @ first, first.T @ rest, tuple(within))

    def __add__(self, other: "InnerProducts") -> "InnerProducts":
        """Those of the rows of both."""
        within = tuple(one + two for one, two in zip(self.within, other.within, strict=True))
        return InnerProducts(self.common + other.common, self.across + other.across, within)

    def of_choices(self) -> "list[Array]":
        """For each choice those of the common columns and then its own, shape (p + g, p + g)."""
        ends = np.cumsum([0, *(len(each) for each in self.within)])
        parts = (self.across[:, first:last] for first, last in itertools.pairwise(ends))
        return [np.block([[self.common, a], [a.T, w]]) for a, w in zip(parts, self.within, strict=True)]
