"""Whether fitted parameters are compatible with given values, by all that is known of their uncertainty."""

from collections.abc import Mapping

import numpy as np
from scipy.linalg import pinvh
from scipy.stats import chi2

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel
from dr_lab.diagnosis.fit.covariance import estimate
from dr_lab.physics.context import ContextEstimate


def chance(known: ContextEstimate, values: Mapping[str, float]) -> float:
    """Probability that an estimate lies as far from the given values as it does, if they are the truth.

    Joint Wald test: dᵀ C⁻¹ d of the differences d with their covariance C is χ² with as many degrees of freedom as
    there are values. Parameters that can replace one another are judged together; a direction whose variance is
    nothing but rounding is left out.

    Source: Wald, Transactions of the American Mathematical Society 54 (1943) 426.

    Args:
        known: the estimate; its covariance should hold the scatter between logs (`covariance.estimate`).
        values: by parameter name, at least one.
    """
    rows = [known.space.index(name) for name in values]
    std = known.std[rows]
    away = (known.mean[rows] - np.array(list(values.values()))) / std
    together = known.covariance[np.ix_(rows, rows)] / np.outer(std, std)
    return float(chi2.sf(away @ pinvh(together) @ away, len(rows)))


def known_of(bench: Bench, fitted_model: FittedModel) -> ContextEstimate:
    """What the fit windows tell of a model's parameters, the scatter between logs included."""
    return estimate(fitted_model.model.space, fitted_model.fit, bench.fit, bench.evidence)
