"""How one effect contains another, poorer one of the catalogue at the same site."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class SpecialCase:
    """How a richer effect becomes a poorer one; parameters by their short names.

    Attributes:
        further: the parameters that only the richer effect has. With all of them at zero, or in the limit towards zero,
            it acts as the poorer one.
        same: the parameters that both have, the richer one's name → the poorer one's; empty if the quantities differ.
    """

    further: tuple[str, ...]
    same: Mapping[str, str] = field(default_factory=dict)
