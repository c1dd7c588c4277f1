"""What free laws have in common: they act as effects of a model, but belong to no catalogue."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from dr_lab.physics.law import Law
from dr_lab.physics.model import ModelEffect
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class FreeLaw:
    """A law of one argument with so many parameters that it is next to any function of it.

    It acts beside the effect whose law it checks; fulfils `physics.model.ModelEffect`.

    Attributes:
        label: unique within a model.
        parameters: all that it asks for in a context.
        own: those that make it free; nominal = 0 = nothing beside the effect.
    """

    label: str
    parameters: tuple[Parameter, ...]
    own: tuple[Parameter, ...]

    def beside(self, effect: ModelEffect) -> tuple[ModelEffect, ...]:
        """What stands in a model in the place of the effect."""
        return (effect, self)

    def prepare(self, spec: mujoco.MjSpec) -> None:
        """Nothing."""
        del spec

    def edit(self, spec: mujoco.MjSpec, values: Mapping[str, float]) -> None:
        """Nothing."""
        del spec, values

    def reading(self, values: Mapping[str, Array], channel: str, read: Reading, begin: Array) -> Reading:
        """Sensors report what they did."""
        del values, channel, begin
        return read

    def command(self, values: Mapping[str, Array], actuator: str, series: Array, option: mujoco.MjOption) -> Array:
        """Commands stay."""
        del values, actuator, option
        return series

    def drivers(self, values: Mapping[str, Array], compiled: mujoco.MjModel) -> tuple[Law, ...]:
        """None: a free law is for replays, whose commands are known ahead."""
        del values, compiled
        return ()

    def force_laws(self, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> tuple[Law, ...]:
        """None."""
        del values, models
        return ()

    def lacking(self, values: Mapping[str, float], option: mujoco.MjOption) -> str:
        """Nothing: a free law is never exported."""
        del values, option
        return ""


def curve(x: Array, knots: Array, values: Array) -> Array:
    """Piecewise linear curve through a value at each knot, held beyond the outermost ones.

    Args:
        x: where, shape (n, …).
        knots: ascending, shape (k,), k ≥ 2.
        values: at the knots, one curve for each of the n rows of x, shape (k, n).
    """
    inside = np.clip(x, knots[0], knots[-1])
    left = np.clip(np.searchsorted(knots, inside, side="right") - 1, 0, len(knots) - 2)
    share = (inside - knots[left]) / (knots[left + 1] - knots[left])
    row = np.arange(len(x)).reshape(-1, *[1] * (x.ndim - 1))
    return (1 - share) * values[left, row] + share * values[left + 1, row]
