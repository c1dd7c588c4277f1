"""The report of summarize; `summarize.schema.json` says what each key means."""

from collections.abc import Mapping
from dataclasses import dataclass

from dr_lab.reports.plain import Number

SCHEMA = "dr_lab/summarize/1"


@dataclass(frozen=True)
class GroupEntry:
    """Runs with the same settings, and their figures by path."""

    settings: Mapping[str, str]
    runs: tuple[str, ...]
    figures: Mapping[str, Mapping[str, Number]]


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
