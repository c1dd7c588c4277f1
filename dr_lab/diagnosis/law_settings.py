"""How the law of a named effect is checked; the values live in conf/comparison."""

from dataclasses import dataclass

from dr_lab.errors import require_numbers


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

    knots: int
    factor: float
    least_closed: float

    def __post_init__(self) -> None:
        least, most = {"knots": 1.0, "least_closed": 0.0}, {"least_closed": 1.0}
        require_numbers(self, "evidence.law", positive=("factor",), least=least, most=most)
