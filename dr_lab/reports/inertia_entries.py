"""The entry of a gap report on the inertial parameters of its bodies."""

from collections.abc import Mapping
from dataclasses import dataclass

from dr_lab.reports.gap_entries import ByChannel, Labels
from dr_lab.reports.plain import Number


@dataclass(frozen=True)
class BodyEntry:
    """What a fitted body weighs, and where its centre is in its own frame."""

    mass: Number
    mass_std: Number
    centre: tuple[Number, ...]
    centre_std: tuple[Number, ...]


@dataclass(frozen=True)
class InertiaEntry:
    """Which combinations of the bodies' inertial parameters the logs know."""

    parameters: int
    rank: int
    known: int
    condition: Number
    chosen: Labels
    held: Labels
    best: tuple[ByChannel, ...]
    worst: tuple[ByChannel, ...]
    bodies: Mapping[str, BodyEntry]
