"""Bounds that a fit ran into, moved where they are but the place at which one looks first."""

import math
from dataclasses import replace

import numpy as np

from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.parameter import AT_A_BOUND, Parameter
from dr_lab.trajectory import Array


def widened(placed: PlacedEffect, values: Array, windows: Windows) -> PlacedEffect | None:
    """The effect with those bounds twice as far from absent that its fit ran into; None where none may be moved.

    A bound at absent or at 0 stays, and one that is physics or as far as the windows can show (`Effect.limit`). A lower
    bound between 0 and absent is halved, also of a shape that may get sharper (`Effect.sharpened`).

    Args:
        placed: the effect.
        values: of its parameters as fitted.
        windows: those of the fit.
    """
    limits = _limits(placed, windows)
    found = tuple(map(_wider, placed.parameters, values.tolist(), limits))
    return None if found == placed.parameters else placed.moved(found)


def reach(placed: PlacedEffect, windows: Windows, times: int) -> tuple[Array, Array]:
    """How far the bounds of an effect may be moved at so many times, in their widths, below and above, shape (k,) each.

    Args:
        placed: the effect.
        windows: those of a fit.
        times: how often each may be moved.
    """
    far = np.zeros((2, len(placed.parameters)))
    for place, (parameter, limit) in enumerate(zip(placed.parameters, _limits(placed, windows), strict=True)):
        wide = parameter
        for _ in range(times):
            wide = _wider(_wider(wide, wide.low, limit), wide.high, limit)
        far[:, place] = parameter.low - wide.low, wide.high - parameter.high
        far[:, place] /= parameter.high - parameter.low
    return far[0], far[1]


def ran_into(parameter: Parameter, value: float) -> tuple[bool, bool]:
    """Whether a value lies at the lower and at the upper bound, absent excepted."""
    low, high = parameter.ends(value)
    return low and parameter.low < parameter.nominal, high and parameter.high > parameter.nominal


def _limits(placed: PlacedEffect, windows: Windows) -> list[float]:
    """How far from nominal the bounds of each parameter may be moved; those of a shape that may get sharper, to 0."""
    kept, effect = windows.past.shape[1] * windows.step, placed.effect
    short = {p: p.name.removeprefix(f"{placed.label}.") for p in placed.parameters}
    return [
        p.high - p.nominal if name in effect.sharpened else effect.limit(name, kept, windows.margin)
        for p, name in short.items()
    ]


def _wider(parameter: Parameter, value: float, limit: float) -> Parameter:
    below, above = ran_into(parameter, value)
    low = _farther(parameter.low, parameter.nominal, limit) if below else parameter.low
    high = _farther(parameter.high, parameter.nominal, limit) if above else parameter.high
    return replace(parameter, low=low, high=high)


def _farther(bound: float, nominal: float, limit: float) -> float:
    """A bound twice as far from nominal, at most as far as the limit; where it already is there, as it is."""
    if limit <= 0 or bound == 0:
        return bound
    if 0 < bound < nominal:
        return bound / 2
    far = abs(bound - nominal)
    farther = min(2 * far, limit)
    return nominal + math.copysign(farther, bound - nominal) if farther > (1 + AT_A_BOUND) * far else bound
