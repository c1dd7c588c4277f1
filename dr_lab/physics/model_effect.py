"""An effect at a site of a model, as a model sees it."""

from collections.abc import Mapping
from typing import Protocol, TypeVar

import mujoco

from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

Value = TypeVar("Value", float, Array)


class ModelEffect(Protocol):
    """An effect at a site of a model, as a model sees it."""

    @property
    def label(self) -> str:
        """``effect@site``, unique within a model."""
        ...

    @property
    def site(self) -> str:
        """The element that it sits at."""
        ...

    @property
    def elements(self) -> tuple[str, ...]:
        """The elements that it acts at, with the same values: the site, or all for which the site stands."""
        ...

    @property
    def effect(self) -> object:
        """What acts there; its base classes of `effect_parts` say in which parts of the physics."""
        ...

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The effect's parameters, nominal = absent."""
        ...

    @property
    def attached(self) -> bool:
        """Whether it is absent from logs that were recorded without a load."""
        ...

    def replayed(self, spec: mujoco.MjSpec) -> "ModelEffect":
        """The effect as it acts on a machine where all commands are known ahead; itself if that is no difference."""
        ...

    def local(self, values: Mapping[str, Value]) -> dict[str, Value]:
        """The effect's own values out of a whole context's, by the names that its parts know them by."""
        ...
