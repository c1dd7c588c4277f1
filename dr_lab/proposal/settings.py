"""How a proposal is judged by the data; the values live in conf/init.yaml."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from dr_lab.bounds import Count, Positive, Share, above, require_bounds
from dr_lab.measurements.contract import DataContract


@dataclass(frozen=True)
class ProposalSettings:
    """How a proposal is judged by the data.

    Attributes:
        contract: thresholds of the data contract.
        seconds: s, of the logs that are looked at.
        logs: how many of them at most.
        grid: s, between two times at which the equation of motion is tested.
        half_width: s, of a test function.
        tests: test functions.
        cutoff: Hz, at which the smoother passes half of a motion.
        lags: s, by which commands may act late.
        most_orders: orders of columns that are tried exhaustively; of more, swaps are tried.
        near: readings that leave up to this many times the least squares count as equally good …
        close: … and those that leave this share of the squares more.
        well: share of the squares that the best reading may leave before offsets of angles are tried.
        explained: share of the squares that a command must take away.
        weighs: share of the squares left without gravity that gravity must take away if an angle gets an offset.
        fits: share of the squares that may be left.
        far: times the size of its model that a slide may move before its unit is doubted …
        violent: m/s², if it is accelerated by more than this as well.
        nothing: share of the squares that a series leaves as a position, above which it is tried as a velocity.
        gain: commands that act with less than this, or more than its inverse, have another unit.
        near_unit: ratio up to which a gain passes for a unit.
        rests_after: s after a command's step from which a joint may be at rest.
        rests_moved: share of a position's range within which it rests.
        rests_off: share of the rests' range by which they may miss a line, and the line zero.
        jump: share of its range by which a series without a name for it jumps at once that is no position …
        jump_samples: … if it changes from one sample to the next in no more than this share of them.
        derivative: least correlation of a velocity with its position's derivative.
        alike: least correlation of two series that are of one motion.
        held_out: share of the logs that are never fitted.
        several: windows that a held-out log should hold, where one does.
        reach: share of the whole motion by which a held-out log may reach beyond the fitted ones.
        spread: bounds of a mass are the documented one over and times this.
        distinct: share of what a mass does that no other parameter does.
        felt: share of the forces that a mass must move.
        gain_off: share by which a command's gain must differ from 1 for that to be told, and for an inertia to be free
            in place of a mass …
        certain: … and standard deviations of it.
        turns: correlation above which an angular rate is that of an orientation.
        derived: the same from sample to sample, above which it may be computed from it.
        text: share of a column's cells that may be text for it to be called one of numbers.
        counts: of an encoder a turn, the usual first; whole numbers without a unit may be these.
        touching: share of the motion in which two bodies touch that overlap by their shapes.
        timestep: s, of a URDF.

    Raises:
        ConfigError: a number is out of its range.
    """

    contract: DataContract
    seconds: Positive
    logs: Count
    grid: Positive
    half_width: Positive
    tests: Count
    cutoff: Positive
    lags: Sequence[float]
    most_orders: Count
    near: Annotated[float, above(1.0)]
    close: Share
    well: Share
    explained: Share
    weighs: Share
    fits: Share
    nothing: Share
    far: Positive
    violent: Positive
    gain: Share
    near_unit: Annotated[float, above(1.0)]
    rests_after: Positive
    rests_moved: Share
    rests_off: Share
    jump: Share
    jump_samples: Share
    derivative: Share
    alike: Share
    held_out: Share
    several: Count
    reach: Share
    spread: Annotated[float, above(1.0)]
    distinct: Share
    felt: Share
    gain_off: Share
    certain: Positive
    turns: Share
    derived: Share
    text: Share
    counts: Sequence[int]
    touching: Share
    timestep: Positive

    def __post_init__(self) -> None:
        require_bounds(self, "proposal")
