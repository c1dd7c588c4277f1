"""What a point does in the plane."""

from dataclasses import dataclass

from dr_lab.bounds import Count, NotNegative, Positive, require_bounds


@dataclass(frozen=True, kw_only=True)
class Walk:
    """How far a step goes, and when walking ends.

    Attributes:
        time_limit: control steps after which an episode is cut.
        stride: farthest that a step goes along x and along y, m.
        reached: an episode ends where x and y are both nearer to the goal than this, m; 0 never ends it.
        seconds: length of a control step, s. It changes no episode, only the clock of its recording.

    Raises:
        ConfigError: a number is out of its range.
    """

    time_limit: Count
    stride: Positive
    reached: NotNegative
    seconds: Positive

    def __post_init__(self) -> None:
        require_bounds(self, "env.task")
