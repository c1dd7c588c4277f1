"""The report of evaluate; `evaluate.schema.json` says what each key means. Keys with a default may be absent."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from dr_lab.reports.episode_entry import EpisodeEntry
from dr_lab.reports.plain import Number

SCHEMA = "dr_lab/evaluate/1"

Cell = float | str | None


@dataclass(frozen=True)
class EvaluateReport:
    """What an evaluator found of a trained policy; `report.json` holds it."""

    schema: str
    verb: str
    trained: str
    env: str
    evaluator: str
    figures: Mapping[str, Number]
    rows: tuple[Mapping[str, Cell], ...]
    run: str
    units: Mapping[str, str] = field(default_factory=dict)
    episodes: tuple[EpisodeEntry, ...] = ()
