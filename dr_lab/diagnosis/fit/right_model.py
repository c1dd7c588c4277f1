"""What a right model may leave."""

from scipy.stats import chi2


def most_chi2(freedom: float, floor: float, confidence: float) -> float:
    """Largest χ² per degree of freedom at which a model counts as right.

    On few samples the χ² of a right model scatters, and exceeds this quantile of its distribution only with probability
    1 − confidence.

    Args:
        freedom: degrees of freedom of the χ².
        floor: to which the noise is known; on many samples it is the largest.
        confidence: that a right model counts as one.
    """
    return max(floor, float(chi2.ppf(confidence, freedom)) / freedom) if freedom > 0 else floor
