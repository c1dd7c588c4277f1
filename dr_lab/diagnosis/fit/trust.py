"""Whether the intervals of a fit can be trusted, and which parameters the data tell apart worst."""

import numpy as np

from dr_lab.diagnosis.fit.base_parameters import HALF, combination
from dr_lab.diagnosis.fit.covariance import clusters
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.physics.context import ContextEstimate, ContextSpace


def doubts(found: ContextEstimate, fit: Fit, windows: Windows, settings: EvidenceSettings) -> dict[str, list[str]]:
    """Why the intervals of a context may be wrong, by parameter; empty lists where nothing speaks against them.

    An interval covers residuals that are coloured and logs that disagree through the bootstrap of `covariance`. It is
    not to be trusted where there are too few blocks to resample, where the value lies at its bound, and where its
    standard deviation is so large that the prior decides.
    """
    count = len(clusters(windows, settings))
    few = [_few(count, windows, settings)] if count < settings.least_trusted else []
    edge, width = at_bounds(found), found.std / found.space.span
    prior = fit.equations.prior**-0.5
    reasons: dict[str, list[str]] = {}
    for k, name in enumerate(found.space.names):
        bound = ["at its bound"] if edge[name] else []
        prior_alone = ["the data hardly move it"] if width[k] > HALF * prior[k] else []
        reasons[name] = [*few, *bound, *prior_alone]
    return reasons


def _few(count: int, windows: Windows, settings: EvidenceSettings) -> str:
    """That so few logs, or blocks of a single one, were fitted."""
    logs = len(np.unique(windows.log)) > 1
    what = (
        f"{count} logs are" if logs else f"{count} block{'s' * (count != 1)} of one log {'are' if count != 1 else 'is'}"
    )
    return f"only {what} fitted; from {settings.least_trusted} on (evidence.least_trusted) their scatter is known"


def at_bounds(found: ContextEstimate) -> dict[str, bool]:
    """Whether each parameter lies at one of its bounds; one that the fit left alone does not."""
    rows = zip(found.space.parameters, found.mean.tolist(), found.std.tolist(), strict=True)
    return {p.name: any(p.touches(value)) and std > 0 for p, value, std in rows}


def worst_direction(space: ContextSpace, fit: Fit) -> dict[str, float]:
    """The direction in which the data know least of the context, in widths of the bounds; its length is 1.

    The eigenvector of the information, the starts being eliminated, with the smallest eigenvalue: parameters of this
    combination trade against each other. Entries that are small are left out.
    """
    return combination(np.linalg.eigh(fit.equations.reduced.information)[1][:, 0], space.names)
