"""What a rival could give along a course, as columns of a regression."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from dr_lab.plants.alike.response import Signature
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Choice:
    """One shape of a rival: fixed + Σ coefficient · column, each coefficient within bounds.

    Attributes:
        columns: what a unit of each coefficient adds to the model's residual force and readings.
        low: lower bounds, one for each column.
        high: upper bounds.
        fixed: what is added anyway; None adds nothing.
    """

    columns: Sequence[Signature]
    low: Sequence[float]
    high: Sequence[float]
    fixed: Signature | None = None

    @property
    def signatures(self) -> tuple[Signature, ...]:
        """What is fixed, then the columns."""
        return (*(() if self.fixed is None else (self.fixed,)), *self.columns)


@dataclass(frozen=True)
class Rival:
    """An effect of the catalogue at a site, as far as it can show along a course.

    Attributes:
        label: ``effect@site``.
        parameters: their number in the catalogue.
        choices: its shapes; any of them may be true.
    """

    label: str
    parameters: int
    choices: Sequence[Choice] = field(default_factory=tuple)


def linear(*columns: Signature, positive: Sequence[bool] | bool = False) -> tuple[Choice]:
    """The single shape of a rival that is linear in all its parameters, some of which cannot be negative."""
    signs = [positive] * len(columns) if isinstance(positive, bool) else positive
    return (Choice(columns, [0.0 if sign else -np.inf for sign in signs], [np.inf] * len(columns)),)


def along(points: Sequence[Signature]) -> tuple[Choice, ...]:
    """The shapes of a rival whose one parameter bends what it gives: straight lines from each point to the next.

    Between two neighbours the line is off by an eighth of the second difference of the points.
    """
    return tuple(
        Choice([Signature(after.force - before.force, after.reading - before.reading)], [0.0], [1.0], before)
        for before, after in itertools.pairwise(points)
    )


def mixed(points: Sequence[Signature], fixed: Signature | None = None) -> tuple[Choice, ...]:
    """The shapes of a rival with a factor and a parameter that bends what it gives: sums of neighbouring points.

    Of a + b parts a of one point and b of the next are nearly a + b times what a point between them gives.
    """
    pairs = itertools.pairwise(points)
    return tuple(Choice([before, after], [0.0, 0.0], [np.inf, np.inf], fixed) for before, after in pairs)


def pushing(shape: Array, joint: int, joints: int) -> Signature:
    """What a force at one joint, shape (K,), takes from what a model lacks."""
    force = np.zeros((len(shape), joints))
    force[:, joint] = -shape
    return lacked(force)


def showing(joint: int, joints: int, position: Array | float = 0.0, speed: Array | float = 0.0) -> Signature:
    """What an encoder and a tachometer read in excess, at least one of them of shape (K,)."""
    shape, speed = np.broadcast_arrays(position, speed)
    reading = np.zeros((len(shape), 2 * joints))
    reading[:, joint], reading[:, joints + joint] = shape, speed
    return Signature(np.zeros((len(shape), joints)), reading)


def lacked(force: Array) -> Signature:
    """A change of what a model lacks, shape (K, n)."""
    return Signature(force, np.zeros((len(force), 2 * force.shape[1])))
