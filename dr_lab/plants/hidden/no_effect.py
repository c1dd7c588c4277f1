"""Nothing hidden."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class NoEffect(HiddenEffect):
    """The machine as documented, parameters aside."""

    name: ClassVar[str] = "none"
    site: str = ""

    @property
    def label(self) -> str:
        """``none``."""
        return self.name
