"""The entries of a gap report (schema dr_lab/gap/1).

`gap.schema.json` says what each key means, once; here stands which there are and of which type. SI units.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from dr_lab.reports.plain import IN_PLACE, OMITTED, Number

Interval = tuple[Number, Number]
ByChannel = Mapping[str, Number]
Labels = tuple[str, ...]  # of effects, ``effect@site``


@dataclass(frozen=True)
class NoiseEntry:
    """Noise of a channel, and the error that the time step makes in it."""

    std: Number
    unit: str
    source: str
    numerical: Number = None


@dataclass(frozen=True)
class LogsEntry:
    """Names of the logs that are fitted, and of those that score."""

    fit: tuple[str, ...]
    held_out: tuple[str, ...]


@dataclass(frozen=True)
class WindowsEntry:
    """How long windows are, and how many are fitted, choose between models, and choose nothing."""

    length: float
    fit: int
    held_out: int
    confirm: int


TRADE = "trade"  # kind of the notes that stand beside the parameters
TOGETHER, SHORT_SHIFT, IN_DOUBT, MEASURABLE = "together", "short_shift", "in_doubt", "measurable"  # the verdict's kinds


@dataclass(frozen=True)
class NoteEntry:
    """One sentence that a reader must know; `effect` where it is about the fit of one candidate."""

    message: str
    kind: str
    log: str | None = field(default=None, metadata=OMITTED)
    signal: str | None = field(default=None, metadata=OMITTED)
    fault: str | None = field(default=None, metadata=OMITTED)
    count: int | None = field(default=None, metadata=OMITTED)
    effect: str | None = field(default=None, metadata=OMITTED)


@dataclass(frozen=True)
class LogScatterEntry:
    """What the logs say of a parameter one by one; how much of its std the time step gives; why that may be wrong."""

    cv_percent: Number = None
    per_log: ByChannel = field(default_factory=dict)
    doubts: tuple[str, ...] = ()
    bounds: Interval = (None, None)
    std_by_step: Number = None


@dataclass(frozen=True)
class ParameterEntry:
    """A parameter's value; `at_bound` where it was fitted, `scatter` where it was fitted on all windows."""

    value: Number
    std: Number
    unit: str
    at_bound: bool | None = field(default=None, metadata=OMITTED)
    scatter: LogScatterEntry | None = field(default=None, metadata=IN_PLACE)


Parameters = Mapping[str, ParameterEntry]


@dataclass(frozen=True)
class ErrorsEntry:
    """Errors of a model on the logs that score."""

    chi2: Number
    rmse: ByChannel
    degrees_of_freedom: Number = None
    nrmse: ByChannel = field(default_factory=dict)
    fit_percent: ByChannel = field(default_factory=dict)
    chi2_predicted: Number = None
    rmse_predicted: ByChannel = field(default_factory=dict)
    infeasible_windows: int = 0


@dataclass(frozen=True)
class FitEntry:
    """How a fit ended."""

    converged: bool
    iterations: int
    windows: int
    infeasible_windows: int


@dataclass(frozen=True)
class RungEntry:
    """One model of the ladder; `fit` where it was fitted, `rivals` where effects are judged, `learned` where it is."""

    effects: Labels
    held_out: ErrorsEntry
    parameters: Parameters
    fit: FitEntry | None = field(default=None, metadata=OMITTED)
    rivals: Labels | None = field(default=None, metadata=OMITTED)
    learned: bool | None = field(default=None, metadata=OMITTED)


@dataclass(frozen=True)
class RemainingEntry:
    """What the last model leaves."""

    status: str
    chi2: Number
    coloured: bool = False


@dataclass(frozen=True)
class RegionEntry:
    """A region where the model fails."""

    signal: str
    region: str
    share: Number
    samples: Number = None
    chi2: Number = None


@dataclass(frozen=True)
class HorizonEntry:
    """Errors after so many seconds of open-loop prediction."""

    horizon: Number
    rmse: ByChannel


@dataclass(frozen=True)
class CorrelationEntry:
    """How far a residual follows a command."""

    signal: str
    command: str
    peak_lag: Number
    peak: Number
    band: Number
    significant: bool


@dataclass(frozen=True)
class ConfirmingGainEntry:
    """What the added effects gain on windows that chose nothing."""

    chi2_before: Number = None
    chi2_after: Number = None
    gap_closed: Number = None
    gain: Number = None
    gain_ci: Interval = (None, None)
    evidence: Number = None
    evidence_low: Number = None


@dataclass(frozen=True)
class ConfirmationEntry:
    """What the windows say that chose nothing; no `gain` where there are none."""

    status: str
    predicted_worse: bool
    windows: int
    gain: ConfirmingGainEntry | None = field(default=None, metadata=IN_PLACE)


@dataclass(frozen=True)
class ExplainedEntry:
    """How much of what the calibrated model misses the added effects remove."""

    share: Number = None
    low: Number = None
    high: Number = None
    channels: ByChannel = field(default_factory=dict)


@dataclass(frozen=True)
class LawEntry:
    """What a free law of the same argument explains of what a named effect leaves."""

    effect: str
    argument: str
    explains: Number
    refuted: bool
    free_parameters: int = 0
    evidence: Number = None
    evidence_low: Number = None
    told: str = ""


@dataclass(frozen=True)
class CandidateEntry:
    """One candidate of a ranking."""

    effect: str
    site: str
    held_out_chi2: Number
    gain: Number
    gain_ci: Interval
    status: str
    parameters: Parameters
    evidence: Number = None
    evidence_low: Number = None
    wins: Number = None
    fitted: bool = True
    final: bool = True
    gap_closed: ByChannel = field(default_factory=dict)
    predicted_gain: Number = None
    absorbed_by_parameters: bool = False
    replaced_by: Mapping[str, float] = field(default_factory=dict)
    excitation: Number = None

    @property
    def label(self) -> str:
        """``effect@site``."""
        return f"{self.effect}@{self.site}"


@dataclass(frozen=True)
class JudgedRungEntry:
    """The verdict at one step of the ladder."""

    verdict: str | None
    reason: str
    effects: Labels = ()
    chosen: Labels = ()
    on_trial: Labels = ()
    absorbed_by_parameters: Labels = ()
    ranking: tuple[CandidateEntry, ...] = ()


@dataclass(frozen=True)
class SharpenedEntry:
    """A poorly known parameter that the next experiment would tell better: its standard deviation now and then."""

    parameter: str
    unit: str
    std: Number
    std_after: Number


@dataclass(frozen=True)
class ExperimentEntry:
    """The experiment that would decide between rivals, or sharpen parameters; or the reason why there is none."""

    separates: Labels = ()
    sigma: Number = None
    command_file: str = ""
    needed: float = 0.0
    duration: Number = None
    rate: Number = None
    start: Mapping[str, float] = field(default_factory=dict)
    hold: Mapping[str, float] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    rests: bool = True
    taken: Number = None
    sharpens: tuple[SharpenedEntry, ...] = ()
    reason: str = ""
