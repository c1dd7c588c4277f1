"""The report of compare, fit, diagnose, add and close; `gap.schema.json` says what each key means."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from dr_lab.reports.force_entries import LearnedEntry, MissingForceEntry
from dr_lab.reports.gap_entries import (
    CandidateEntry,
    ConfirmationEntry,
    CorrelationEntry,
    ExperimentEntry,
    ExplainedEntry,
    HorizonEntry,
    JudgedRungEntry,
    Labels,
    LawEntry,
    LogsEntry,
    NoiseEntry,
    NoteEntry,
    RegionEntry,
    RemainingEntry,
    RungEntry,
    WindowsEntry,
)
from dr_lab.reports.inertia_entries import InertiaEntry
from dr_lab.reports.plain import IN_PLACE, OMITTED, Number
from dr_lab.trajectory import ClockFit

SCHEMA = "dr_lab/gap/1"


@dataclass(frozen=True)
class Failure:
    """Where and over which horizon the first model of the ladder fails."""

    where: tuple[RegionEntry, ...] = ()
    horizons: tuple[HorizonEntry, ...] = ()
    input_correlation: tuple[CorrelationEntry, ...] = ()


@dataclass(frozen=True)
class Judgement:
    """What a verb that judges effects says beyond errors and parameters."""

    confirmation: ConfirmationEntry | None = None
    gap_closed: Number = None
    explained: ExplainedEntry = field(default_factory=ExplainedEntry)
    reason: str = ""
    laws: tuple[LawEntry, ...] = ()
    ranking: tuple[CandidateEntry, ...] = ()
    rungs: tuple[JudgedRungEntry, ...] = ()
    worst_direction: Mapping[str, float] = field(default_factory=dict)
    learned: tuple[LearnedEntry, ...] = ()
    missing_force: tuple[MissingForceEntry, ...] = ()
    next_experiment: ExperimentEntry | None = None
    confidence: Number = None


@dataclass(frozen=True)
class GapReport:
    """What a comparing verb found; `report.json` holds it."""

    schema: str
    verb: str
    model: str
    measurements: str
    noise: Mapping[str, NoiseEntry]
    logs: LogsEntry
    windows: WindowsEntry
    clocks: Mapping[str, Mapping[str, ClockFit]]
    notes: tuple[NoteEntry, ...]
    verdict: str | None
    ladder: tuple[RungEntry, ...]
    remaining: RemainingEntry
    run: str
    as_given: RungEntry | None = field(default=None, metadata=OMITTED)
    inertia: InertiaEntry | None = field(default=None, metadata=OMITTED)
    judgement: Judgement | None = field(default=None, metadata=IN_PLACE)
    failure: Failure | None = field(default=None, metadata=IN_PLACE)

    @property
    def catalogued(self) -> tuple[RungEntry, ...]:
        """The models of the ladder without those that have a learned force, which has no name."""
        return tuple(rung for rung in self.ladder if not rung.learned)

    @property
    def added(self) -> Labels:
        """The effects with a name that the last model has and the first of the ladder has not."""
        return tuple(effect for effect in self.catalogued[-1].effects if effect not in self.ladder[0].effects)

    @property
    def judged(self) -> Judgement:
        """What was judged; all of it is empty where nothing was."""
        return self.judgement or Judgement()

    @property
    def failing(self) -> Failure:
        """Where the model fails; empty where nobody looked."""
        return self.failure or Failure()
