"""What free laws have in common: they act as effects of a model, but belong to no catalogue."""

from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from dr_lab.physics.model_effect import ModelEffect, Value
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class FreeLaw:
    """A law of one argument with so many parameters that it is next to any function of it.

    It acts beside the effect whose law it checks, in replays alone; fulfils `physics.model_effect.ModelEffect`.

    Attributes:
        label: unique within a model.
        site: the element that it sits at.
        parameters: all that it asks for in a context.
        own: those that make it free; nominal = 0 = nothing beside the effect.
    """

    label: str
    site: str
    parameters: tuple[Parameter, ...]
    own: tuple[Parameter, ...]

    @property
    def elements(self) -> tuple[str, ...]:
        """The site alone."""
        return (self.site,)

    @property
    def effect(self) -> "FreeLaw":
        """Itself: it is made for its site."""
        return self

    @property
    def attached(self) -> bool:
        """It acts in all logs."""
        return False

    def replayed(self, spec: mujoco.MjSpec) -> "FreeLaw":
        """Itself."""
        del spec
        return self

    def local(self, values: Mapping[str, Value]) -> dict[str, Value]:
        """Its own values out of a context's, by full name."""
        return {p.name: values[p.name] for p in self.parameters}

    def beside(self, effect: ModelEffect) -> tuple[ModelEffect, ...]:
        """What stands in a model in the place of the effect."""
        return (effect, self)


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
