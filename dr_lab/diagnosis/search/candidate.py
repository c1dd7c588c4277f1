"""One effect at one site that a model may lack."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.evidence.paired_gain import Gain
from dr_lab.diagnosis.fit.identifiability import Identifiability
from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.effects.effect import PlacedEffect


@dataclass(frozen=True)
class Candidate:
    """One effect at one site, compared with the same model without it.

    Attributes:
        effect: the placed effect.
        fitted_model: the model with the effect; fitted to and scored on a part of the windows where it is not final.
        gain: paired gain over the model without it, on the windows that score it.
        identifiability: what the data can say of it.
        predicted: share of the cost on the fit windows that a linear step could remove.
        windows: to which it was fitted, all of the fit windows or a part of them.
        fitted: whether the effect was fitted; else it stayed absent, as its prediction was too small.
        final: whether it was fitted to all windows; else another candidate had beaten it on a part of them, or
            explained as much with fewer parameters.
        needless: of one that is not final: whether it explained as much as the best one on that part, to which another
            one with fewer parameters came near enough.
        resolved: whether it is more than a shift in time by less than `Bench.timing_resolution`; an integrator's own
            error is such a shift, and so is what a command that is logged too rarely leaves.
    """

    effect: PlacedEffect
    fitted_model: FittedModel
    gain: Gain
    identifiability: Identifiability
    predicted: float
    windows: Windows
    fitted: bool = True
    final: bool = True
    needless: bool = False
    resolved: bool = True

    def told(self) -> "Candidate":
        """What a report tells of a candidate that goes no farther: without slopes, which hundreds fill memory with."""
        if self.final:
            return self
        nothing, fit = np.arange(0), self.fitted_model.fit
        fit = replace(fit, slopes=fit.slopes.pick(nothing), first=fit.first.pick(nothing))
        if not self.fitted:
            fit = replace(fit, equations=fit.equations.pick(nothing))
        return replace(self, fitted_model=replace(self.fitted_model, fit=fit))


def resolved(effect: PlacedEffect, values: Mapping[str, float], least: float) -> bool:
    """Whether an effect with these values, by name, is more than a shift in time by less than `least` s."""
    if any(p.unit != "s" for p in effect.parameters):
        return True
    return any(abs(values[p.name] - p.nominal) >= least for p in effect.parameters)
