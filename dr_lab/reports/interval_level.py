"""What an interval of a few results may claim."""

from collections.abc import Iterable

from dr_lab.reports.quantity import percent

FEWEST = 3
"""Results that have an interval: of two it would be these two, between which the truth lies in one of two cases."""


def level(confidence: float, count: int) -> float:
    """How often an interval by the percentile bootstrap covers the truth, at most.

    It lies between the smallest and the largest of its results. With k of them, all are on one side of the median of
    what they are drawn from with probability 2 · 2⁻ᵏ, so that the interval covers it in 1 − 2¹⁻ᵏ of all cases at most,
    whatever confidence is asked for: 75 % of three results, 88 % of four, 94 % of five.

    Args:
        confidence: that is asked for, below 1.
        count: independent results, `FEWEST` at least.
    """
    return min(confidence, 1.0 - 2.0 ** (1 - count))


def levels_told(confidence: float, counts: Iterable[int]) -> str:
    """A sentence on intervals of so few runs that they cover less than is asked for; empty where there are none."""
    few = [k for k in sorted(set(counts)) if k >= FEWEST and level(confidence, k) < confidence]
    told = [f"of {k} runs {percent(level(confidence, k))}" for k in few]
    return f"Intervals of few runs cover less: {', '.join(told)} at most." if told else ""
