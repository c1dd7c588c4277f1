"""What windows that chose nothing say of a ladder's last model beside the calibrated one."""

from collections.abc import Callable
from dataclasses import dataclass
from math import isnan

from dr_lab.diagnosis.bench import Bench, Explained
from dr_lab.diagnosis.evidence import Gain, paired_gain
from dr_lab.diagnosis.replay import Replay
from dr_lab.diagnosis.score import Score, score_of
from dr_lab.diagnosis.states import StateFit
from dr_lab.diagnosis.windows import Windows
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array

Fits = Callable[[Model, Array, Windows], tuple[Replay, StateFit]]


@dataclass(frozen=True)
class Confirmation:
    """Two models on windows that chose neither.

    Attributes:
        windows: how many there are.
        before: score of the calibrated model.
        after: score of the last model.
        gain: paired gain of the last model.
    """

    windows: int
    before: Score
    after: Score
    gain: Gain

    @property
    def contradicts(self) -> bool:
        """Whether the last model explains these windows no better, on more of them than a chance."""
        return self.gain.total <= 0 and not isnan(self.gain.total_low)

    @property
    def status(self) -> str:
        """Whether the gain that chose the effects is found again.

        ``confirmed`` (beyond doubt), ``undecided`` (there, but not beyond doubt on so few windows) or
        ``contradicted`` (the last model explains these windows no better).
        """
        if self.contradicts:
            return "contradicted"
        return "confirmed" if self.gain.total_low > 0 else "undecided"


def confirm(bench: Bench, base: Explained, last: Explained, fits: Fits) -> Confirmation | None:
    """Compare a ladder's ends on the windows that chose nothing.

    Args:
        bench: holds these windows.
        base: the calibrated model.
        last: the model that was chosen.
        fits: fits the windows' states under a model at a context.

    Returns:
        The comparison; None where nothing was added, or no windows were left for it.
    """
    windows = bench.confirms
    if windows is None or last is base:
        return None
    before, after = (score_of(*fits(each.model, each.fit.z, windows)) for each in (base, last))
    return Confirmation(len(windows), before, after, paired_gain(before, after, bench.evidence))
