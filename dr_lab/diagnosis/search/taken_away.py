"""Where the fit of a model begins when an effect is taken away from one that was fitted with it."""

import numpy as np

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.point import Point


def taken_away(fitter: Fitter, whole: FittedModel) -> list[Point]:
    """Two starts: with the other parameters as they were, and where they make up best for what is gone.

    A mass takes over from a payload, where the fit with the payload had gone on farther. Without that the effect would
    get the credit for what the others can do alone.

    Args:
        fitter: of the model that lacks something.
        whole: the model that has it, fitted to the same windows.
    """
    names, space = fitter.space.names, whole.model.space
    gone = {p.name: p.nominal for p in space.parameters if p.name not in names}
    rows = [space.index(name) for name in names]
    ends = (whole.fit.z, whole.fit.delta), whole.fit.made_up(space, gone)
    return [fitter.begin(np.asarray(z[rows]), delta) for z, delta in ends]
