"""How the law of a named effect is checked; the values live in conf/comparison."""

from dataclasses import dataclass
from typing import Annotated

from dr_lab.bounds import Count, Positive, at_least, at_most, require_bounds


@dataclass(frozen=True)
class LawSettings:
    """How the law of a named effect is checked against free laws of the same argument.

    Attributes:
        knots: of a free curve of a command on either side of zero; a curve of a position has twice as many in all.
        factor: largest free force of a position, in units of the joint's torque in the logs.
        least_closed: share of the gap which the named effect leaves that a free law must close to refute it.

    Raises:
        ConfigError: a number is out of its range.
    """

    knots: Count
    factor: Positive
    least_closed: Annotated[float, at_least(0.0), at_most(1.0)]

    def __post_init__(self) -> None:
        require_bounds(self, "evidence.law")
