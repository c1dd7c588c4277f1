"""Any number of phenomena at once."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.composite import Composite
from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class Several(Composite):
    """Each on top of the one before, in the order of the mapping.

    Attributes:
        effects: the phenomena, by any name.
        site: none of its own.
    """

    name: ClassVar[str] = "several"
    effects: Mapping[str, HiddenEffect]
    site: str = ""

    @property
    def parts(self) -> tuple[HiddenEffect, ...]:
        """The phenomena."""
        return tuple(self.effects.values())
