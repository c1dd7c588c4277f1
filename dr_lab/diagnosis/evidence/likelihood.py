"""Which of two models is less likely where one of them leaves noise alone."""

import numpy as np

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.evidence.noise_floor import alone_at_floor
from dr_lab.diagnosis.evidence.paired_gain import paired_gain
from dr_lab.diagnosis.evidence.support import sizeable
from dr_lab.diagnosis.settings import EvidenceSettings


def less_likely(model: FittedModel, other: FittedModel, extra: int, settings: EvidenceSettings) -> bool:
    """Whether all logs together make a model less likely than another one.

    1. One with more parameters displaces one with fewer if it is more likely on the fitted and on the held-out logs. A
       model that holds the truth gains on both; a fit that ended early, or a start that was not found, shows on one.
    2. Any other displaces one if it is more likely on both kinds of logs together.
    3. One at the noise floor displaces one above it if its evidence is `sizeable`, and lets no further window diverge.

    Args:
        model: the one that may be displaced.
        other: the one that may displace it.
        extra: number of parameters that the other one has more; below 0 if it has fewer.
        settings: how much more likely is enough.
    """
    excess = _excess(model, other)
    if (min(excess) if extra > 0 else sum(excess)) > settings.threshold + settings.penalty * extra:
        return True
    if not alone_at_floor(other.held_out, model.held_out, settings):
        return False
    gain = paired_gain(model.held_out, other.held_out, settings)
    return sizeable(gain, extra, settings) and not np.isneginf(gain.total_low)


def _excess(model: FittedModel, other: FittedModel) -> tuple[float, ...]:
    """How much larger a model's χ² is than another one's: on the held-out logs, and on the fitted ones.

    Only windows that both simulate count. The unit is the noise that the other one leaves, per independent residual.
    Without held-out logs the scored ones are the fitted ones, which then count once.
    """
    ours, theirs = model.held_out, other.held_out
    both = (ours.window_count > 0) & (theirs.window_count > 0)
    unit = max(theirs.chi2, 1.0) * theirs.colour
    held_out = float((ours.window_sum - theirs.window_sum)[both].sum()) / unit
    fitted = other.fit.below(model.fit) / unit
    return (held_out, fitted) if model.apart else (held_out,)
