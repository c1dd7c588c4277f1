"""The report of train; `train.schema.json` says what each key means. Keys with a default are absent in older files."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from dr_lab.reports.episode_entry import EpisodeEntry
from dr_lab.reports.plain import IN_PLACE, RETURN, Number

SCHEMA = "dr_lab/train/1"


@dataclass(frozen=True)
class HistogramEntry:
    """A distribution as training left it, beside the one that it began with."""

    edges: tuple[float, ...]
    initial: tuple[float, ...]
    probability: tuple[float, ...]


@dataclass(frozen=True)
class ContextEntry:
    """The distribution of one parameter, as training left it."""

    unit: str
    mean: Number
    std: Number
    low: Number
    high: Number
    histogram: HistogramEntry | None = field(default=None, metadata=IN_PLACE)


@dataclass(frozen=True)
class SnapshotEntry:
    """A policy that was kept, and its return where one is chosen."""

    frames: int
    mean_return: Number = field(metadata=RETURN)


@dataclass(frozen=True)
class ChoiceEntry:
    """Which policy is deployed, of those that were kept."""

    snapshots: tuple[SnapshotEntry, ...]
    chosen: int
    choice_frames: int
    policy: str

    @property
    def mean_return(self) -> Number:
        """That of the deployed policy, in the episodes by which it was chosen."""
        return next(each.mean_return for each in self.snapshots if each.frames == self.chosen)


@dataclass(frozen=True)
class MomentsEntry:
    """What was believed of a parameter."""

    unit: str
    mean: Number
    std: Number


@dataclass(frozen=True)
class RungEntry:
    """An iteration of a learner that compares the model with a target, and the distribution after it."""

    iteration: int
    frames: int
    discrepancy: Number
    discrepancy_of_mean: Number
    divergence: Number
    target_steps: int
    context: Mapping[str, MomentsEntry]


@dataclass(frozen=True)
class TrainReport:
    """What a training run came to; `report.json` holds it."""

    schema: str
    verb: str
    env: str
    algorithm: str
    iterations: int
    frames: int
    seconds: float
    final_return: Number
    final: Mapping[str, Number]
    context: Mapping[str, ContextEntry]
    checkpoint: str
    run: str
    rollout_frames: int = 0
    infeasible_episodes: int = 0
    episodes: tuple[EpisodeEntry, ...] = ()
    choice: ChoiceEntry | None = field(default=None, metadata=IN_PLACE)
    adapted_returns: tuple[float, ...] = ()
    ladder: tuple[RungEntry, ...] = ()
    final_episodes: int | None = None
    deployed_return: Number = None
    ended_episodes: int | None = None
