"""From which peaks of a spectrum fits begin; the values live in conf/comparison."""

from dataclasses import dataclass

from dr_lab.bounds import Count, Share, require_bounds


@dataclass(frozen=True)
class PeakSettings:
    """From which peaks of a spectrum over position the fits of an effect that repeats begin.

    Attributes:
        most: number of peaks.
        near: share of the largest peak's gain from which on another one may be the true one, for the response to a push
            is an estimate.

    Raises:
        ConfigError: a number is out of its range.
    """

    most: Count
    near: Share

    def __post_init__(self) -> None:
        require_bounds(self, "evidence.peaks")
