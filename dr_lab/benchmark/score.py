"""Is an answer right? Scored by equivalence class: what the logs cannot tell apart is not asked to be told apart."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from dr_lab.benchmark.outcome import BASE, Outcome

_TOP = 3


@dataclass(frozen=True)
class Mark:
    """How an outcome is judged.

    With several hidden effects an extra one that nobody hid does not undo what was found: an answer that finds every
    truth and names an invented effect beside them, without rivals, is `right` and `false` at once. It counts in the
    rate of what was found and in that of what was named wrongly.

    Attributes:
        right: without anything hidden, ``none``; with something outside of the catalogue, ``unexplained``; with one
            effect, `named` with a member of its class, `equivalent` with exactly the class, or `none` that lists an
            effect whose class holds the base as absorbed or not excited; with several, every one found. Of a lenient
            case everything is right that names no effect without rivals.
        top_3: right, or a member of the class is among the first three of the ranking.
        false: an effect was named, without rivals, that is not in the class of anything hidden.
    """

    right: bool
    top_3: bool
    false: bool


def mark(outcome: Outcome) -> Mark:
    """Judge an outcome."""
    judged = _strictly(outcome)
    if outcome.case.lenient and not any(len(group) == 1 for group in outcome.found):
        return Mark(True, True, judged.false)
    return judged


def identifiable(outcome: Outcome) -> bool:
    """Whether the data can show the one effect that is hidden: its class does not hold the base."""
    return outcome.case.kind == "single" and BASE not in members(outcome, outcome.truths[0])


def _strictly(outcome: Outcome) -> Mark:
    kind = outcome.case.kind
    if kind in ("none", "outside"):
        right = outcome.verdict == ("none" if kind == "none" else "unexplained")
        return Mark(right, right, any(len(group) == 1 for group in outcome.found))
    classes = {truth: members(outcome, truth) for truth in outcome.truths}
    left = unmatched(outcome.found, classes)
    false = any(len(group) == 1 for group in left)
    if kind == "several":
        missing = missed(outcome)
        return Mark(not missing, not missing, false)
    (truth,) = outcome.truths
    right = _single(outcome, truth, classes[truth])
    near = any(label in classes[truth] for label in outcome.ranking[:_TOP])
    return Mark(right, right or near, false)


def members(outcome: Outcome, truth: str) -> dict[str, int]:
    """A truth's class, label → number of parameters; itself alone where the class was not asked for."""
    return dict(outcome.classes.get(truth, {truth: 1}))


def missed(outcome: Outcome) -> list[str]:
    """Truths that no effect was found for; an effect may stand for one truth only.

    A truth is matched with what is called like it, else with what has it for a rival, else with another of its class.
    """
    groups, left = list(outcome.found), list(outcome.truths)
    for stands_for in (_first, _listed, _of_class):
        for truth in list(left):
            match = next((group for group in groups if stands_for(group, truth, outcome)), None)
            if match is not None:
                groups.remove(match)
                left.remove(truth)
    return [truth for truth in left if not _absorbed(outcome, truth)]


def unmatched(found: Sequence[Sequence[str]], classes: Mapping[str, Collection[str]]) -> list[Sequence[str]]:
    """What was found that stands for nothing hidden."""
    return [group for group in found if not any(label in known for label in group for known in classes.values())]


def fewest(known: Mapping[str, int]) -> set[str]:
    """The members of a class with the fewest parameters: a richer effect that explains nothing more is no rival."""
    counts = {label: count for label, count in known.items() if label != BASE}
    return {label for label, count in counts.items() if count == min(counts.values())}


def _single(outcome: Outcome, truth: str, known: Mapping[str, int]) -> bool:
    if not outcome.found:
        return outcome.verdict == "none" and _absorbed(outcome, truth)
    first, *rivals = outcome.found[0]
    return {first, *rivals} == fewest(known) if rivals else first in known


def _absorbed(outcome: Outcome, truth: str) -> bool:
    """Whether the data cannot show the truth, and the answer says so."""
    standing = outcome.standing.get(truth)
    listed = truth in outcome.absorbed or (standing is not None and standing.status == "not_excited")
    return BASE in members(outcome, truth) and listed


def _first(group: Sequence[str], truth: str, outcome: Outcome) -> bool:
    del outcome
    return group[0] == truth


def _listed(group: Sequence[str], truth: str, outcome: Outcome) -> bool:
    del outcome
    return truth in group


def _of_class(group: Sequence[str], truth: str, outcome: Outcome) -> bool:
    return group[0] in members(outcome, truth)
