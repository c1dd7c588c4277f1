"""The report of summarize; `summarize.schema.json` says what each key means. Keys with a default may be absent."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from dr_lab.reports.plain import Number

SCHEMA = "dr_lab/summarize/1"


@dataclass(frozen=True)
class GroupEntry:
    """Runs with the same settings, and their figures by path."""

    settings: Mapping[str, str]
    runs: tuple[str, ...]
    figures: Mapping[str, Mapping[str, Number]]


@dataclass(frozen=True)
class SamplingEntry:
    """Contexts that the runs of a group drew, counted, and whether they are uniform."""

    group: str
    parameter: str
    unit: str
    runs: int
    frames: tuple[int, ...]
    edges: tuple[float, ...]
    count: tuple[tuple[int, ...], ...]
    low: Number
    high: Number
    chi2: Number
    dof: int
    p: Number
    p_between: Number


@dataclass(frozen=True)
class InterferenceEntry:
    """Cosines between the policy gradients of contexts, mean and spread over the runs of a group."""

    group: str
    parameter: str
    unit: str
    runs: int
    frames: int
    values: tuple[float, ...]
    mean: tuple[tuple[Number, ...], ...]
    spread: tuple[tuple[Number, ...], ...]
    doubtful: tuple[tuple[bool, ...], ...]


@dataclass(frozen=True)
class SummarizeReport:
    """What the runs below a folder came to; `report.json` holds it."""

    schema: str
    verb: str
    sweep: str
    groups: tuple[GroupEntry, ...]
    unfinished: tuple[str, ...]
    notes: tuple[str, ...]
    run: str
    sampling: tuple[SamplingEntry, ...] = ()
    interference: tuple[InterferenceEntry, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
