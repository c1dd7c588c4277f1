"""When a fault of a log is told; the values live in conf/comparison."""

from dataclasses import dataclass
from typing import Annotated

from dr_lab.bounds import Count, NotNegative, Positive, Share, at_least, require_bounds
from dr_lab.diagnosis.faults.smoothed_motion import EquationErrorSettings
from dr_lab.diagnosis.faults.unit_suspicion import ReadingSettings


@dataclass(frozen=True)
class FaultSettings:
    """When a fault of a log is told.

    Attributes:
        equation: how the equation of motion is tested.
        gain: commands that act with less than this, or more than its inverse, have another unit or do nothing.
        near_unit: ratio up to which such a factor passes for one between units.
        contrast: another reading of the commands must leave at most this share of the squares that the given one does.
        share: the given reading must leave at least this share of the squares of what the motion needs.
        longest_delay: s, no machine reacts later; what is later is a shift of the log.
        longest_shift: s, longest shift looked for.
        shift_step: s, between the shifts tried.
        shortest_off: s, shortest span in which a machine can be seen to be off.
        active: share of a log's beginning or end from which a first gain is taken; in the rest the machine may be off.
        idle: share of the drive's squares that the motion's need leaves in such a span, at most.
        idle_contrast: what the drive leaves there exceeds what it leaves elsewhere by this factor.
        rare: commands that come more rarely than this many of the model's steps are also read as lines between their
            samples.
        coarse: commands that come more rarely than this many steps of the equation's grid are tested for missing ones.
        straight: commands that go straight from sample to sample must leave at most this share of the squares of held
            ones for some to be missing.
        held_margin: what holds a joint exceeds what the motion elsewhere leaves by this many standard deviations.
        shortest_held: s, shortest rest at a log's end in which a joint can be seen to be held.
        resting: speed as a share of the log's below which a joint counts as at rest in a span.
        breakaway: friction holds a joint at rest against this many times the friction of its motion.
        wrong: largest error of a nominal model's gravity and inertia, as a share of them; of its springs and offsets,
            as a share of what the motion needs.
        overdone: share of what the motion needs by which the model's own friction may be too large.
        slow: share of the log's speed below which the direction of friction is undecided.
        fewest: test functions that a regression is worth.
        known: share of a log's test functions that must know the commands of another time.
        misread_seconds: s of the logs, at most, on which other units and orders of their channels are tried.
        reading: when channels seem to be read in another unit or sign than they have.

    Raises:
        ConfigError: a number is out of its range.
    """

    equation: EquationErrorSettings
    gain: Share
    near_unit: Annotated[float, at_least(1.0)]
    contrast: Share
    share: Positive
    longest_delay: Positive
    longest_shift: Positive
    shift_step: Positive
    shortest_off: Positive
    active: Share
    idle: Positive
    idle_contrast: Annotated[float, at_least(1.0)]
    rare: Positive
    coarse: Positive
    straight: Positive
    held_margin: Positive
    shortest_held: Positive
    resting: NotNegative
    breakaway: Annotated[float, at_least(1.0)]
    wrong: Share
    overdone: Share
    slow: Share
    fewest: Count
    known: Share
    misread_seconds: Positive
    reading: ReadingSettings

    def __post_init__(self) -> None:
        require_bounds(self, "faults")

    @property
    def least_span(self) -> float:
        """The shortest log in s that holds as many test functions as a regression is worth."""
        return 2 * self.equation.half_width + (self.fewest - 1) * self.equation.hop

    def is_coarse(self, wait: float) -> bool:
        """Whether commands `wait` s apart come so rarely that lines between them may miss much of what was sent."""
        return wait > self.coarse * self.equation.step
