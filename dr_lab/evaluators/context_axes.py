"""Which contexts an evaluator compares: a grid over some parameters, the others nominal."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from dr_lab.errors import ConfigError
from dr_lab.physics.context import ContextSpace
from dr_lab.recorders.training import ContextAxis
from dr_lab.trajectory import Array

_ROUNDING = 1e-12  # share of a range that is nothing but rounding


def context_axes(
    space: ContextSpace, given: Mapping[str, Sequence[float]] | None, count: int, most: int
) -> list[ContextAxis]:
    """The axes of a grid.

    Args:
        space: all parameters.
        given: by parameter, [lowest, highest, number of values] in SI units; None takes all, within their bounds.
        count: values of a parameter where `given` is None.
        most: axes that the evaluator can draw.

    Raises:
        ConfigError: there are more parameters to vary, or none, or a range is none.
        UnknownNameError: an axis is no parameter.
    """
    if not space.names:
        raise ConfigError(
            "The evaluator compares contexts, and what the run was trained on has no parameters to vary. Train with "
            "some: env/context=…, as dr-lab train --help lists them."
        )
    every = zip(space.names, space.low, space.high, strict=True)
    chosen = given if given is not None else {name: (low, high, count) for name, low, high in every}
    if not 1 <= len(chosen) <= most:
        first = list(zip(space.names, space.low, space.high, strict=True))[:most]
        example = ", ".join(f"{name}: [{low:.4g}, {high:.4g}, {count}]" for name, low, high in first)
        raise ConfigError(
            f"The evaluator draws {' or '.join(['one', 'two'][:most])} parameter{'s' * (most > 1)}; here it is "
            f"{len(chosen)}: {', '.join(chosen) or 'none'}. Choose the lowest, the highest and the number of values: "
            f"'evaluator.axes={{{example}}}'. The model has {', '.join(space.names) or 'no parameters'}."
        )
    return [_axis(space, name, *limits) for name, limits in chosen.items()]


def _axis(space: ContextSpace, name: str, *given: float) -> ContextAxis:
    index = space.index(name)
    if len(given) != 3 or not all(map(isfinite, given)) or given[0] >= given[1] or given[2] < 2 or given[2] % 1:
        raise ConfigError(
            f"evaluator.axes.{name} is {list(given)}; expected [lowest, highest, number of values], at least two."
        )
    values = np.linspace(given[0], given[1], int(given[2]))
    values[np.abs(values) < _ROUNDING * (given[1] - given[0])] = 0.0
    return ContextAxis(name, space.parameters[index].unit, values)


def cells(space: ContextSpace, axes: Sequence[ContextAxis]) -> Array:
    """Contexts of a grid, the last axis running fastest, shape (cells, n)."""
    z = []
    for values in itertools.product(*(axis.values for axis in axes)):
        row = space.nominal.copy()
        for axis, value in zip(axes, values, strict=True):
            row[space.index(axis.name)] = value
        z.append(row)
    return np.array(z)


def within(space: ContextSpace, z: Array) -> NDArray[np.bool_]:
    """Whether contexts (k, n) lie within the bounds, but for rounding, shape (k,)."""
    slack = _ROUNDING * space.span
    return np.all((z >= space.low - slack) & (z <= space.high + slack), axis=1)


def in_groups(z: Array, size: int) -> Iterator[tuple[Array, int]]:
    """Contexts (k, n) as groups of one size.

    Yields:
        A group (size, n), and how many of its first contexts count; the others repeat the last.
    """
    for first in range(0, len(z), size):
        group = z[first : first + size]
        yield np.concatenate([group, np.repeat(group[-1:], size - len(group), axis=0)]), len(group)
