"""What reports of training and evaluation say of an episode that is shown."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from dr_lab.reports.plain import RETURN, Number


@dataclass(frozen=True)
class ValueEntry:
    """The value of a parameter."""

    value: Number
    unit: str


@dataclass(frozen=True)
class EpisodeEntry:
    """One episode: its undiscounted return, how long it lasted, why it ended, and in which context."""

    name: str
    undiscounted: Number = field(metadata=RETURN)
    seconds: Number
    ended: str
    context: Mapping[str, ValueEntry]
