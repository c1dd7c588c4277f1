"""When an effect acts as another, poorer one of the catalogue at the same site."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class SpecialCase:
    """How a poorer effect is held by a richer one; parameters by their short names.

    Attributes:
        further: the richer effect's parameters that the poorer one does not have; with all of them at zero, or in the
            limit towards it, the richer effect acts as the poorer one.
        same: the richer effect's parameters that are the poorer one's, by the richer one's names; empty where they are
            not the same quantity.
    """

    further: tuple[str, ...]
    same: Mapping[str, str] = field(default_factory=dict)
