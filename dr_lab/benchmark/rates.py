"""What a benchmark's outcomes come to: rates with their intervals, and errors."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from scipy.stats import binomtest

from dr_lab.benchmark.case import Kind
from dr_lab.benchmark.outcome import Outcome
from dr_lab.benchmark.score import identifiable, mark
from dr_lab.benchmark.scoring import Aliases
from dr_lab.reports.benchmark import Rate

CONFIDENCE = 0.95
DEVIATIONS = 2.0  # to either side; 95 % of a Gaussian
_ABSTENTIONS = ("equivalent", "none", "unexplained")


def rate(happened: Iterable[bool]) -> Rate | None:
    """The rate of something; None where there was no case of it."""
    seen = list(happened)
    if not seen:
        return None
    interval = binomtest(sum(seen), len(seen)).proportion_ci(CONFIDENCE, method="wilson")
    return Rate(sum(seen), len(seen), sum(seen) / len(seen), float(interval.low), float(interval.high))


def rates(outcomes: Sequence[Outcome], parameter_aliases: Aliases) -> dict[str, Rate | None]:
    """The benchmark's rates, by name.

    ``top_1`` and ``top_3`` of machines with one effect, ``identifiable`` as ``top_1`` of those whose effect the data
    can show, ``both_found`` of those with several, ``doubles`` of those with two, ``false_alarm`` of those without
    any, ``wrong_with_confidence`` of all, ``outside_unexplained`` of those with an effect that the catalogue does not
    hold; ``abstained_equivalent``, ``…_none`` and ``…_unexplained`` of those with one effect: how often the answer was
    that, right or not. ``parameter_within_stated`` of the main parameters of right answers: see `within_stated`.
    """
    marks = {outcome.case: mark(outcome) for outcome in outcomes}
    single = _of("single", outcomes)
    return {
        "top_1": rate(marks[o.case].right for o in single),
        "top_3": rate(marks[o.case].top_3 for o in single),
        "identifiable": rate(marks[o.case].right for o in single if identifiable(o)),
        "both_found": rate(marks[o.case].right for o in _of("several", outcomes)),
        "doubles": rate(marks[o.case].right for o in _of("several", outcomes) if len(o.truths) == 2),
        "false_alarm": rate(bool(o.found) for o in _of("none", outcomes)),
        "wrong_with_confidence": rate(marks[o.case].false for o in outcomes),
        "outside_unexplained": rate(marks[o.case].right for o in _of("outside", outcomes)),
        **{f"abstained_{kind}": rate(o.verdict == kind for o in single) for kind in _ABSTENTIONS},
        "parameter_within_stated": rate(held for o in outcomes for held in within_stated(o, parameter_aliases)),
    }


def medians(outcomes: Sequence[Outcome], parameter_aliases: Aliases) -> dict[str, float | None]:
    """Median held-out χ² where the catalogue holds what is hidden, median parameter error, and costs in s."""
    within = [o for o in outcomes if o.case.kind != "outside"]
    errors = [error for o in within for error in parameter_errors(o, parameter_aliases).values()]
    cpu, wall = [o.cpu for o in outcomes], [o.wall for o in outcomes]
    return {
        "median_chi2": _median([o.chi2 for o in within if np.isfinite(o.chi2)]),
        "median_parameter_error": _median(errors),
        "median_cpu": _median(cpu),
        "mean_cpu": float(np.mean(cpu)) if cpu else None,
        "median_wall": _median(wall),
    }


def parameter_errors(outcome: Outcome, parameter_aliases: Aliases) -> dict[str, float]:
    """| |fitted| − |truth| | / |truth| of the main parameter of each truth that was found, by its full name.

    Args:
        outcome: whose truth is known by the plant's names.
        parameter_aliases: names of the plant's numbers in the catalogue; ``inverse_…`` is the reciprocal. The first of
            the plant's names that the catalogue has too is the main one.
    """
    errors = {}
    for truth, short, value in _main_parameters(outcome, parameter_aliases):
        found = outcome.fitted[truth][short]
        found = 1 / found if short.startswith("inverse_") and found else found
        errors[f"{truth}.{short}"] = abs(abs(found) - abs(value)) / abs(value)
    return errors


def within_stated(outcome: Outcome, parameter_aliases: Aliases) -> list[bool]:
    """Whether the stated interval, `DEVIATIONS` to either side, holds the main parameter of each truth that was found.

    Of answers that are right and leave noise: what else a model misses, no interval can know.
    """
    if outcome.remaining != "at_floor" or not mark(outcome).right:
        return []
    held = []
    for truth, short, value in _main_parameters(outcome, parameter_aliases):
        std = outcome.stated.get(truth, {}).get(short, np.nan)
        if np.isfinite(std):
            given = 1 / value if short.startswith("inverse_") else value
            held.append(abs(abs(outcome.fitted[truth][short]) - abs(given)) <= DEVIATIONS * std)
    return held


def _main_parameters(outcome: Outcome, parameter_aliases: Aliases) -> Iterator[tuple[str, str, float]]:
    """Each truth that was found with the short name of its main parameter and the plant's number for it.

    A truth whose fitted number is not finite is left out: nothing is known of it.
    """
    for truth, fitted in outcome.fitted.items():
        own, names = outcome.magnitudes.get(truth, {}), parameter_aliases.get(truth.partition("@")[0], {})
        main = next(((names.get(n, n), v) for n, v in own.items() if names.get(n, n) in fitted and v), None)
        if main is not None and np.isfinite(fitted[main[0]]):
            yield truth, *main


def _of(kind: Kind, outcomes: Sequence[Outcome]) -> list[Outcome]:
    return [o for o in outcomes if o.case.kind == kind]


def _median(values: Sequence[float]) -> float | None:
    return float(np.median(values)) if values else None
