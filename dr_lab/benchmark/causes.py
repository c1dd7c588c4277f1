"""Why an answer is wrong, in one sentence made from how the truth stood."""

from dr_lab.benchmark.outcome import BASE, Outcome
from dr_lab.benchmark.score import fewest, mark, members, missed
from dr_lab.reports.quantity import number, percent


def cause(outcome: Outcome) -> str:
    """The cause of a miss; empty for a right answer."""
    if mark(outcome).right:
        return ""
    kind, answer = outcome.case.kind, _answer(outcome)
    if kind == "none":
        if outcome.found:
            return f"{answer} lowers the held-out χ² from {number(outcome.chi2_base)} to {number(outcome.chi2)}."
        return f"The model itself stays at χ² {number(outcome.chi2_base)}, above the noise floor."
    if kind == "outside":
        return f"{answer or 'Nothing'} is answered; χ² {number(outcome.chi2_base)} → {number(outcome.chi2)}."
    if kind == "several":
        return " ".join(_of_truth(outcome, truth) for truth in missed(outcome))
    return _of_truth(outcome, outcome.truths[0])


def _answer(outcome: Outcome) -> str:
    return "; ".join(" or ".join(group) for group in outcome.found)


def _of_truth(outcome: Outcome, truth: str) -> str:
    """Why one truth was not found."""
    known, standing = members(outcome, truth), outcome.standing.get(truth)
    if standing is None:
        return f"{truth} was no candidate."
    if BASE in known:
        return f"{truth} does not show in these logs, but is not listed as such ({standing.status})."
    answer = outcome.found[0] if outcome.found else []
    if outcome.verdict == "equivalent" and set(answer) & known.keys():
        lacking, foreign = sorted(fewest(known) - {*answer}), sorted({*answer} - fewest(known))
        parts = [f"lacks {', '.join(lacking)}"] * bool(lacking) + [f"adds {', '.join(foreign)}"] * bool(foreign)
        return f"The set of equivalent effects {' and '.join(parts)}."
    if not standing.fitted:
        return f"{truth} was not fitted: a linear step promised {percent(standing.promised)} of the cost."
    evidence = f"evidence {number(standing.evidence, 3)} (at least {number(standing.evidence_low, 3)})"
    stood = f"{truth} came {standing.place}. with χ² {number(standing.chi2)}, {evidence}"
    return f"{stood}, closing {percent(standing.gap)} of the gap."
