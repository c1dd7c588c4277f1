"""Who is told how a climb goes on."""

from collections.abc import Callable, Sequence
from typing import Protocol


class ClimbWatch(Protocol):
    """Is told what begins and what was found so far."""

    def phase(self, text: str) -> None:
        """Something else begins."""
        ...

    def ranking(self, labels: Sequence[str]) -> Callable[[str], None]:
        """These candidates are tried now; what is returned is called with the label of each that is done."""
        ...

    def found(self, labels: Sequence[str], before: float, after: float) -> None:
        """The climb goes on beside these effects, which may be dropped again.

        Args:
            labels: ``effect@site`` of each, in the order in which they were added.
            before: χ² of the calibrated model, on the logs that judge.
            after: χ² with the effects.
        """
        ...


class Silence:
    """A watch that tells nobody."""

    def phase(self, text: str) -> None:
        """Keep it."""

    def ranking(self, labels: Sequence[str]) -> Callable[[str], None]:
        """Keep it, and each label."""
        del labels
        return lambda label: None

    def found(self, labels: Sequence[str], before: float, after: float) -> None:
        """Keep it."""
