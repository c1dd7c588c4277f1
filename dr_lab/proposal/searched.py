"""What a search of the positions found, and whether it found a command for each actuator."""

from collections.abc import Sequence
from dataclasses import dataclass

from dr_lab.proposal.drives import Drive, explains
from dr_lab.proposal.gyros import Gyros
from dr_lab.proposal.search import Found
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.survey import Series
from dr_lab.proposal.trial import Trial


@dataclass(frozen=True)
class Searched:
    """A search.

    Attributes:
        trial: what it tried readings with.
        found: the reading that fits best.
        asked: series that were tried as commands; the drives of the trial.
        drives: actuators that they may command.
        vain: series that were tried as commands, too, and explain nothing.
        gyros: the gyroscopes that the readings were compared with; None without any.
    """

    trial: Trial
    found: Found
    asked: tuple[Series, ...]
    drives: tuple[Drive, ...]
    vain: tuple[Series, ...] = ()
    gyros: Gyros | None = None

    def lacks_command(self, settings: ProposalSettings) -> bool:
        """Whether no series explains the motion of an actuator's joint; one to be added may not be needed."""
        outcome = self.found.outcome
        return any(
            not any(explains(given, drive, outcome, settings) for given in outcome.given[drive.dof])
            for drive in self.drives
            if not drive.added or float(outcome.left[drive.dof]) > settings.well
        )

    def explained_by(self, series: Sequence[Series], settings: ProposalSettings) -> bool:
        """Whether one of some series explains the motion of an actuator's joint."""
        places = {k for k, each in enumerate(self.asked) if each in series}
        outcome = self.found.outcome
        return any(
            given.series in places and explains(given, drive, outcome, settings)
            for drive in self.drives
            for given in outcome.given[drive.dof]
        )
