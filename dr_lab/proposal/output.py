"""What is found of the joints' positions."""

from dataclasses import dataclass

from dr_lab.proposal.drives import Drive
from dr_lab.proposal.search import Found
from dr_lab.proposal.survey import Series
from dr_lab.proposal.trial import Trial


@dataclass(frozen=True)
class Position:
    """A proposed output.

    Attributes:
        channel: ``<joint>.position`` or ``<joint>.velocity``.
        series: what holds it.
        unit: of its numbers.
        sign: +1 or −1.
        offset: in that unit.
        wrap: whether the numbers jump by full turns.
        why: what speaks for it.
    """

    channel: str
    series: Series
    unit: str
    sign: int
    offset: float
    wrap: bool
    why: str


@dataclass(frozen=True)
class Positions:
    """What is known of the joints' positions.

    Attributes:
        outputs: found, in the model's order.
        found: the reading that the equation of motion chose; None where it could not be tested.
        trial: what it was chosen with; None likewise.
        commands: series that may be commands; the drives of the trial.
        drives: actuators that they may command.
        doubts: what is unsure, a sentence each.
    """

    outputs: tuple[Position, ...]
    found: Found | None
    trial: Trial | None
    commands: tuple[Series, ...]
    drives: tuple[Drive, ...]
    doubts: tuple[str, ...]
