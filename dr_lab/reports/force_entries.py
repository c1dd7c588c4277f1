"""The entries of a gap report on forces that a model misses: their formula, and what was learned of them."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from dr_lab.reports.gap_entries import Interval
from dr_lab.reports.plain import Number


@dataclass(frozen=True)
class TermEntry:
    """A term of a formula, and as `effects.formula` takes it."""

    term: str
    coefficient: Number
    unit: str = ""
    expression: str = ""


@dataclass(frozen=True)
class ForceFormulaEntry:
    """A sparse formula of the force that the last model misses."""

    ceiling: Number
    share: Number
    terms: tuple[TermEntry, ...]


@dataclass(frozen=True)
class MissingForceEntry:
    """The force that models miss at a joint."""

    joint: str
    unit: str
    rms_first: Number
    rms_last: Number
    noise: Number
    explained: Number
    ceiling: Number
    left: ForceFormulaEntry | None
    windows: int = 0


@dataclass(frozen=True)
class LearnedEntry:
    """A force that nobody catalogued, as it was learned at a joint, and what held-out logs say of it."""

    joint: str
    effect: str
    depends_on: tuple[str, ...]
    accepted: bool
    removes: Number
    predicted: Mapping[str, Interval] = field(default_factory=dict)
    chi2: Interval = (None, None)
