"""What windows that chose nothing say of a ladder's last model beside the calibrated one."""

from collections.abc import Callable
from dataclasses import dataclass
from math import isnan

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel
from dr_lab.diagnosis.evidence.noise_floor import at_floor
from dr_lab.diagnosis.evidence.paired_gain import Gain, paired_gain
from dr_lab.diagnosis.evidence.score import Score, score_of
from dr_lab.diagnosis.evidence.support import certain, largest_gap
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import StateFit
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array

Fits = Callable[[Model, Array, Windows], tuple[Replay, StateFit]]


@dataclass(frozen=True)
class Comparison:
    """Two models on other windows than those that chose them.

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


@dataclass(frozen=True)
class Confirmation:
    """A ladder's ends on windows that chose neither.

    Attributes:
        apart: on windows that were left out of all choices; None where there are none.
        predicted: on windows whose start is known from earlier samples alone; two thirds of these have dropped what did
            not predict better than the models below.
        predicted_worse: whether the calibrated model predicts windows, from starts that only earlier samples tell,
            better than the last one beyond doubt and by no trifle, and the last one leaves more than noise there. What
            was added then bends the fitted starts, not the motion. The threshold that guards a choice among many is not
            asked for.
        grown: whether the last model leaves more than noise on the windows that were left out, and there
            `EvidenceSettings.growth` times as much as the calibrated one, or as noise.
    """

    apart: Comparison | None
    predicted: Comparison
    predicted_worse: bool
    grown: bool = False

    @property
    def enough(self) -> bool:
        """Whether there are windows left out of all choices, and enough of them to know."""
        return self.apart is not None and not isnan(self.apart.gain.total_low)

    @property
    def contradicts(self) -> bool:
        """Whether what was added is not found again.

        It predicts worse, or gains nothing on windows left out. Where these are too few to know, the error must have
        grown there.
        """
        if self.predicted_worse or self.apart is None:
            return self.predicted_worse
        return self.apart.gain.total <= 0 and (self.enough or self.grown)

    @property
    def status(self) -> str:
        """``confirmed`` (found again beyond doubt), ``undecided`` (found, but not beyond doubt) or ``contradicted``."""
        if self.contradicts:
            return "contradicted"
        return "confirmed" if self.apart is not None and self.apart.gain.total_low > 0 else "undecided"


def confirm(bench: Bench, predicted: Windows, base: FittedModel, last: FittedModel, fits: Fits) -> Confirmation | None:
    """Compare a ladder's ends on windows that chose nothing.

    Args:
        bench: holds the windows that were left out of all choices.
        predicted: windows whose start is known from earlier samples alone.
        base: the calibrated model.
        last: the model that was chosen.
        fits: fits the windows' states under a model at a context.

    Returns:
        The comparison; None where nothing was added.
    """
    if last is base:
        return None
    apart = None if bench.confirms is None else _compared(bench, bench.confirms, base, last, fits)
    known = _compared(bench, predicted, base, last, fits)
    back = paired_gain(known.after, known.before, bench.evidence)
    sure = certain(back, bench.evidence) and largest_gap(back) >= bench.evidence.least_gap
    worse = sure and not at_floor(known.after, bench.evidence)
    return Confirmation(apart, known, worse, apart is not None and _grown(apart, bench.evidence))


def _grown(apart: Comparison, evidence: EvidenceSettings) -> bool:
    grown = apart.after.chi2 >= evidence.growth * max(apart.before.chi2, 1.0)
    return grown and not at_floor(apart.after, evidence)


def _compared(bench: Bench, windows: Windows, first: FittedModel, second: FittedModel, fits: Fits) -> Comparison:
    before, after = (score_of(*fits(each.model, each.fit.z, windows)) for each in (first, second))
    return Comparison(len(windows), before, after, paired_gain(before, after, bench.evidence))
