"""How the runs of a sweep are summarised."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from dr_lab.summaries.groups import Statistics
from dr_lab.summaries.sampling import SamplingSettings


@dataclass(frozen=True)
class SummarySettings:
    """Which runs are taken together, and what of them is compared.

    Attributes:
        aggregate: overrides over which runs are taken together.
        ignored: keys of their configurations that say nothing about the experiment.
        figures: paths into a report that are compared, by its schema.
        statistics: how runs of a group are summed up.
        sampling: how contexts that were drawn are counted.
        reference: label of the group that the others are compared with; None = the first.
    """

    aggregate: Sequence[str]
    ignored: Sequence[str]
    figures: Mapping[str, Sequence[str]]
    statistics: Statistics
    sampling: SamplingSettings
    reference: str | None
