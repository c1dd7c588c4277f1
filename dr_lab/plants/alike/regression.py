"""How well each rival, with everything that is free refitted, gives what a truth gives."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import lsq_linear

from dr_lab.plants.alike.inner_products import InnerProducts
from dr_lab.plants.alike.rival import Choice, Rival
from dr_lab.trajectory import Array

BASE = "base"
_ROUNDING = 1e-12  # share of the largest eigenvalue below which a direction of the regression is none
# Share of a column's square below which nothing of it counts as left: the course is differenced over intervals of some
# milliseconds, which leaves a ten-thousandth of what it should cancel.
_ABSORBED = 1e-7


@dataclass(frozen=True)
class Regression:
    """Least squares on inner products alone.

    Attributes:
        products: of the truths, the free parameters and what `beside` names, in this order, and of the rivals' choices.
        truths: number of truths.
        free: number of free parameters.
        rivals: whose choices they are.
        beside: numbers of columns that give what a rival near to each truth gives; these stay free for other truths.
    """

    products: InnerProducts
    truths: int
    free: int
    rivals: Sequence[Rival]
    beside: Sequence[int] = ()

    def __add__(self, other: "Regression") -> "Regression":
        """The regression on the rows of both, whose columns are the same."""
        return replace(other, products=self.products + other.products)

    def members(self, number: int, labels: Sequence[str], threshold: float) -> dict[str, int]:
        """The class of a truth: label → number of parameters, 0 for the base.

        Where the base is a member every effect is one, staying absent: then no other is listed. Nor is a rival with
        more parameters than the truth's own effect: one that generalises it can always give the same, and claims more.

        Args:
            number: of the truth.
            labels: of all truths; the others keep their sizes free, as do the parameters of their own effects.
            threshold: χ² by which a member may be worse than the truth's own effect of the catalogue.
        """
        freed = self._freed(number)
        left = self.left_by(number)
        own = left.get(labels[number], np.inf)
        own = own if np.isfinite(own) else 0.0  # an effect whose shapes are not worked out gives what it gives
        known = {rival.label: rival.parameters for rival in self.rivals}
        count = known.get(labels[number], 1)
        if without(self.products.common, freed)[number, number] < own + threshold:
            return {labels[number]: count, BASE: 0}
        hidden = set(labels) - {labels[number]}
        alike = {
            label: known[label]
            for label, chi2 in left.items()
            if chi2 < own + threshold and known[label] <= count and label not in hidden
        }
        return {labels[number]: count, **alike}

    def nearest(self, number: int) -> int | None:
        """Place, among all choices, of the one by which any rival comes nearest to a truth; None without any."""
        left = [chi2 for each in self._tried(number, self._freed(number)) for chi2 in each]
        return int(np.argmin(left)) if left else None

    def _freed(self, number: int) -> list[int]:
        """Columns that are regressed out for a truth: all common ones but itself and what stands for it."""
        ends = self.truths + self.free + np.cumsum([0, *self.beside])
        own = range(ends[number], ends[number + 1]) if self.beside else range(0)
        return [k for k in range(len(self.products.common)) if k != number and k not in own]

    def left_by(self, number: int) -> dict[str, float]:
        """Least χ² that each rival leaves of a truth, by its number; infinite of what has no shapes."""
        tried = self._tried(number, self._freed(number))
        return {rival.label: min(each, default=np.inf) for rival, each in zip(self.rivals, tried, strict=True)}

    def _tried(self, number: int, freed: Sequence[int]) -> list[list[float]]:
        """χ² that each choice of each rival leaves of a truth."""
        products, place = iter(self._products), len(self.products.common)
        return [
            [remaining(without(next(products), freed), number, place, choice) for choice in rival.choices]
            for rival in self.rivals
        ]

    @cached_property
    def _products(self) -> list[Array]:
        return self.products.of_choices()


def without(gram: Array, freed: Sequence[int]) -> Array:
    """Inner products of what is left of all columns after some of them are regressed out."""
    if not freed:
        return gram
    size = np.sqrt(np.maximum(np.diag(gram), np.finfo(np.float64).tiny))
    scaled = gram / np.outer(size, size)
    inner, across = scaled[np.ix_(freed, freed)], scaled[:, freed]
    values, vectors = np.linalg.eigh(inner)
    kept = values > _ROUNDING * max(float(values.max()), 0.0)
    part = across @ vectors[:, kept] / np.sqrt(values[kept])
    rest = scaled - part @ part.T
    # What is left of a column that lies among the freed ones is rounding, which would fit anything.
    size[np.diag(rest) < _ABSORBED] = 0.0
    return rest * np.outer(size, size)


def remaining(gram: Array, number: int, place: int, choice: Choice) -> float:
    """Least |truth + fixed + Σ coefficient · column|² of a choice whose signatures begin at a place."""
    end = place + len(choice.signatures)
    columns = list(range(end - len(choice.columns), end))
    offset = np.zeros(len(gram))
    offset[number] = 1.0
    if choice.fixed is not None:
        offset[place] = 1.0
    pulled = gram[columns] @ offset
    size = float(offset @ gram @ offset)
    inner = gram[np.ix_(columns, columns)]
    if len(columns) == 1:
        best = -pulled[0] / inner[0, 0] if inner[0, 0] > 0 else 0.0
        w = np.array([min(max(best, choice.low[0]), choice.high[0])])
    else:
        w = _bounded(inner, pulled, choice)
    return max(size + 2 * float(w @ pulled) + float(w @ inner @ w), 0.0)


def _bounded(inner: Array, pulled: Array, choice: Choice) -> Array:
    """The coefficients of least wᵀ G w + 2 wᵀ p within their bounds."""
    scale = np.sqrt(np.maximum(np.diag(inner), np.finfo(np.float64).tiny))
    values, vectors = np.linalg.eigh(inner / np.outer(scale, scale))
    kept = values > _ROUNDING * max(float(values.max()), np.finfo(np.float64).tiny)
    root = vectors[:, kept].T * np.sqrt(values[kept])[:, None]
    aim = -(vectors[:, kept].T @ (pulled / scale)) / np.sqrt(values[kept])
    low, high = np.asarray(choice.low) * scale, np.asarray(choice.high) * scale
    return np.asarray(lsq_linear(root, aim, (low, high), method="bvls").x) / scale
