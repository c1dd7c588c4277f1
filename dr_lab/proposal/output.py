"""What is found of the outputs: series of the logs that joints and sensors of the model read."""

from dataclasses import dataclass

from dr_lab.proposal.drives import Drive
from dr_lab.proposal.gyros import Gyros
from dr_lab.proposal.search import Found
from dr_lab.proposal.survey import Series
from dr_lab.proposal.trial import Trial


@dataclass(frozen=True)
class Output:
    """A proposed output.

    Attributes:
        channel: ``<joint>.position``, ``<joint>.velocity`` or ``sensor.<name>``.
        parts: what holds it; a vector's components one by one.
        unit: of its numbers.
        sign: +1 or −1.
        offset: in that unit.
        wrap: whether the numbers jump by full turns.
        why: what speaks for it.
        scale: factor into the unit.
        counts: a turn, the usual first, where its whole numbers may be an encoder's and the motion does not tell.
    """

    channel: str
    parts: tuple[Series, ...]
    unit: str
    sign: int
    offset: float
    wrap: bool
    why: str
    scale: float = 1.0
    counts: tuple[int, ...] = ()

    @property
    def entry(self) -> dict[str, object]:
        """How a measurements configuration names it."""
        first = self.parts[0].place
        if len(self.parts) == 1:
            return {**first.entry}
        paths = [each.place.path for each in self.parts]
        return {"topic": first.topic, "field": paths} if first.topic else {"column": paths}

    @property
    def source(self) -> str:
        """What the logs call it."""
        first, *others = (each.place for each in self.parts)
        return ", ".join([str(first), *(each.path for each in others)])


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
        gyros: gyroscopes that joints carry, compared with readings of these; None where there are none to compare.
    """

    outputs: tuple[Output, ...]
    found: Found | None
    trial: Trial | None
    commands: tuple[Series, ...]
    drives: tuple[Drive, ...]
    doubts: tuple[str, ...]
    gyros: Gyros | None = None
