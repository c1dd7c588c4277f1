"""Two phenomena at once."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.composite import Composite
from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class Both(Composite):
    """The second on top of the first.

    Attributes:
        first: a phenomenon.
        second: another one.
        site: none of its own.
    """

    name: ClassVar[str] = "both"
    first: HiddenEffect
    second: HiddenEffect
    site: str = ""

    @property
    def parts(self) -> tuple[HiddenEffect, ...]:
        """First and second."""
        return (self.first, self.second)
