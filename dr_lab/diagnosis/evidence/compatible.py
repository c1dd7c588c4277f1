"""Whether fitted parameters are compatible with given values, by all that is known of their uncertainty."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.linalg import pinvh
from scipy.optimize import lsq_linear
from scipy.stats import chi2, f

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel
from dr_lab.diagnosis.fit.covariance import estimate
from dr_lab.physics.context import ContextEstimate


def chance(
    known: ContextEstimate, values: Mapping[str, float], given: Sequence[str] = (), freedom: float = np.inf
) -> float:
    """Probability that an estimate lies as far from the given values as it does, if they are the truth.

    Joint Wald test: dᵀ C⁻¹ d of the differences d with their covariance C is χ² with as many degrees of freedom as
    there are values. Parameters that can replace one another are judged together; a direction whose variance is
    nothing but rounding is left out.

    Parameters that mean nothing where the values hold (of a friction that falls with speed, the speed, where nothing
    falls) are `given`: they are taken as fitted. Free, each trades with what it shapes, and hides it.

    Where the covariance is the scatter between few logs it is itself badly known, and the statistic, over its number of
    values, follows F rather than χ².

    Source: Wald, Transactions of the American Mathematical Society 54 (1943) 426; Davies, Biometrika 64 (1977) 247;
    Cameron and Miller, Journal of Human Resources 50 (2015) 317, §VI (few clusters).

    Args:
        known: the estimate; its covariance should hold the scatter between logs (`covariance.estimate`).
        values: by parameter name, at least one.
        given: names of parameters that stay as fitted.
        freedom: degrees of freedom of the covariance, one less than the logs that it scatters between.
    """
    rows, fixed = ([known.space.index(name) for name in names] for names in (values, given))
    std = known.std[rows]
    away = (known.mean[rows] - np.array(list(values.values()))) / std
    count, scale = len(rows), np.append(std, known.std[fixed])
    together = known.covariance[np.ix_(rows + fixed, rows + fixed)] / np.outer(scale, scale)
    ours, mixed, theirs = together[:count, :count], together[:count, count:], together[count:, count:]
    statistic = away @ pinvh(ours - mixed @ pinvh(theirs) @ mixed.T) @ away
    return float(chi2.sf(statistic, count) if np.isinf(freedom) else f.sf(statistic / count, count, freedom))


def chance_within(known: ContextEstimate, values: Mapping[str, float]) -> float:
    """The same, where the other parameters make up for the difference within their bounds alone.

    The least of dᵀ C⁻¹ d over all that the others may be, which is the Wald statistic where no bound is in the way.

    Source: Silvapulle and Sen, Constrained Statistical Inference (2005), section 3.4, here with the χ² of all values,
    which is the more careful.

    Args:
        known: the estimate, as for `chance`.
        values: by parameter name, at least one.
    """
    space, free = known.space, np.flatnonzero(known.std > 0)
    place = {name: int(np.flatnonzero(free == space.index(name))[0]) for name in values}
    std, mean = known.std[free], known.mean[free]
    variance, axes = np.linalg.eigh(known.covariance[np.ix_(free, free)] / np.outer(std, std))
    told = variance > np.finfo(float).eps * len(free) * variance[-1]
    root = (axes[:, told] / np.sqrt(variance[told])).T
    rows, rest = list(place.values()), np.setdiff1d(np.arange(len(free)), list(place.values()))
    away = root[:, rows] @ ((np.array(list(values.values())) - mean[rows]) / std[rows])
    statistic = float(away @ away)
    if len(rest):
        ends = [(bound[free] - mean)[rest] / std[rest] for bound in (space.low, space.high)]
        statistic = 2 * float(lsq_linear(root[:, rest], -away, (np.minimum(ends[0], 0), np.maximum(ends[1], 0))).cost)
    return float(chi2.sf(statistic, len(rows)))


def known_of(bench: Bench, fitted_model: FittedModel) -> ContextEstimate:
    """What the fit windows tell of a model's parameters, the scatter between logs included."""
    return estimate(fitted_model.model.space, fitted_model.fit, bench.fit, bench.evidence)
