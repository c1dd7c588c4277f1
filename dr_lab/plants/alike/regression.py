"""How well each rival, with everything that is free refitted, gives what a truth gives."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import lsq_linear

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
        gram: of the truths, the free parameters and the rivals' signatures, in this order, in units of χ².
        truths: number of truths.
        free: number of free parameters.
        rivals: whose choices' signatures follow.
    """

    gram: Array
    truths: int
    free: int
    rivals: Sequence[Rival]

    def members(self, number: int, labels: Sequence[str], threshold: float) -> dict[str, int]:
        """The class of a truth: label → number of parameters, 0 for the base.

        Where the base is a member every effect is one, staying absent: then no other is listed. Nor is a rival with
        more parameters than the truth's own effect: one that generalises it can always give the same, and claims more.

        Args:
            number: of the truth.
            labels: of all truths; the others keep their sizes free, as do the parameters of their own effects.
            threshold: χ² by which a member may be worse than the truth's own effect of the catalogue.
        """
        others = [self._best(other) for other in range(self.truths) if other != number]
        freed = [k for k in range(self.truths + self.free) if k != number]
        freed += [column for (place, choice) in others if choice is not None for column in _columns(place, choice)]
        reduced = without(self.gram, freed)
        left = self._left(reduced, number)
        own = left.get(labels[number], np.inf)
        own = own if np.isfinite(own) else 0.0  # an effect whose shapes are not worked out gives what it gives
        known = {rival.label: rival.parameters for rival in self.rivals}
        count = known.get(labels[number], 1)
        if reduced[number, number] < own + threshold:
            return {labels[number]: count, BASE: 0}
        hidden = set(labels) - {labels[number]}
        alike = {
            label: known[label]
            for label, chi2 in left.items()
            if chi2 < own + threshold and known[label] <= count and label not in hidden
        }
        return {labels[number]: count, **alike}

    def _left(self, reduced: Array, number: int) -> dict[str, float]:
        """Least χ² that each rival leaves of a truth."""
        left: dict[str, float] = {}
        for rival, choices in self._placed:
            tried = (remaining(reduced, number, place, choice) for place, choice in choices)
            left[rival.label] = min(tried, default=np.inf)
        return left

    def _best(self, number: int) -> tuple[int, Choice | None]:
        """Where the choice begins by which any rival comes nearest to a truth, and that choice."""
        reduced = without(self.gram, [k for k in range(self.truths + self.free) if k != number])
        everything = [pair for _, choices in self._placed for pair in choices]
        return min(everything, key=lambda pair: remaining(reduced, number, *pair), default=(0, None))

    @cached_property
    def _placed(self) -> list[tuple[Rival, list[tuple[int, Choice]]]]:
        """Each rival with its choices and where their signatures begin."""
        place, placed = self.truths + self.free, []
        for rival in self.rivals:
            begins = []
            for choice in rival.choices:
                begins.append((place, choice))
                place += len(choice.signatures)
            placed.append((rival, begins))
        return placed


def _columns(place: int, choice: Choice) -> range:
    return range(place + len(choice.signatures) - len(choice.columns), place + len(choice.signatures))


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
    columns = list(_columns(place, choice))
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
