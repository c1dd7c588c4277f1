"""What would explain much of a gap, but not beyond doubt."""

import numpy as np

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.evidence.paired_gain import Gain, paired_gain
from dr_lab.diagnosis.evidence.support import worth_a_trial
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.effects.effect import PlacedEffect
from dr_lab.reports.gap_entries import IN_DOUBT, NoteEntry
from dr_lab.reports.quantity import number, percent


def in_doubt(ladder: Ladder, settings: EvidenceSettings) -> list[NoteEntry]:
    """Note on an effect without support that closes so much of the gap that it is worth a trial.

    1. A climb that ends without an effect dropped one as the last: what that closes alone is told.
    2. Where nothing was added, as `dr-lab diagnose` does, it is the first one that the first rung finds worth a trial.
    3. Of effects that a user added it is the first without support.
    """
    first, doubt = ladder.rungs[0], ladder.doubt
    unproven = next((k for k, step in enumerate(ladder.steps) if not step.proven), None)
    if unproven is not None:
        effect, (base, model) = ladder.steps[unproven].effect, ladder.models[unproven : unproven + 2]
    elif ladder.steps or ladder.verdict(settings) != "unexplained":
        return []
    elif doubt is not None:
        effect, base, model = doubt.step.effect, doubt.base, doubt.step.fitted_model
    elif first.verdict.trial and not ladder.dropped:
        found = next(c for c in first.ranking if c.effect.label == first.verdict.trial[0])
        effect, base, model = found.effect, first.base, found.fitted_model
    else:
        return []
    gain = paired_gain(base.held_out, model.held_out, settings)
    if not worth_a_trial(gain, len(effect.parameters), settings):
        return []
    return [NoteEntry(_told(effect, base, model, gain, settings), IN_DOUBT, effect=effect.label)]


def _told(effect: PlacedEffect, base: FittedModel, model: FittedModel, gain: Gain, settings: EvidenceSettings) -> str:
    before, after = (number(each.held_out.chi2) for each in (base, model))
    return (
        f"**In doubt:** `{effect.label}` closes {percent(gain.gap)} of a typical window's gap, χ² {before} → {after}, "
        f"but {_why(gain, percent(settings.confidence))}. More logs would tell."
    )


def _why(gain: Gain, confidence: str) -> str:
    """Which interval holds nothing as well, and where it is so wide."""
    if np.isnan(gain.total_low):
        return f"there are too few windows to be sure (evidence Δχ² {number(gain.total)})"
    interval = f"evidence Δχ² {number(gain.total)}, {confidence} interval from {number(gain.total_low)}"
    if gain.total_low > 0:
        removed = f"{percent(gain.share)}, {confidence} interval from {percent(gain.low)}"
        interval = f"share of a typical window's χ² that it removes: {removed}"
    among_logs = gain.blocks_low > 0 >= gain.total_low
    far = "some logs gain far more by it than others" if among_logs else "windows gain too unequally by it to be sure"
    return f"{far} ({interval})"
