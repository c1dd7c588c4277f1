"""`benchmark.json` and `cases.csv`: what all outcomes come to, for programs and spreadsheets."""

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from dr_lab.benchmark.case import Case
from dr_lab.benchmark.causes import cause
from dr_lab.benchmark.outcome import Outcome
from dr_lab.benchmark.rates import medians, parameter_errors, rates
from dr_lab.benchmark.score import mark
from dr_lab.effects.effect import FAMILIES, Effect
from dr_lab.recorders.confusion import Confusion, confusion

SCHEMA = "dr_lab/benchmark/1"


@dataclass(frozen=True)
class Goals:
    """What the figures should reach; each by its name in the summary.

    Attributes:
        at_least: lower limits.
        at_most: upper limits.
    """

    at_least: Mapping[str, float]
    at_most: Mapping[str, float]

    def of(self, name: str) -> str:
        """The goal of a figure, in words; empty where there is none."""
        if name in self.at_least:
            return f"≥ {self.at_least[name]:g}"
        return f"≤ {self.at_most[name]:g}" if name in self.at_most else ""

    def met(self, name: str, value: float | None) -> bool | None:
        """Whether a figure reaches its goal; None where either is missing."""
        if value is None or not self.of(name):
            return None
        return self.at_least.get(name, -np.inf) <= value <= self.at_most.get(name, np.inf)


def summary(
    outcomes: Sequence[Outcome],
    failed: Mapping[Case, str],
    goals: Goals,
    parameter_aliases: Mapping[str, Mapping[str, str]],
) -> dict[str, Any]:
    """The figures of a benchmark.

    Args:
        outcomes: the judged cases.
        failed: cases that ended with an error, and what it said.
        goals: what the figures should reach.
        parameter_aliases: as for `parameter_errors`.

    Returns:
        ``schema``, numbers of ``cases`` and of ``failed`` ones by name, ``rates``, ``medians``, ``goals``, ``machines``
        (rates and medians of each) and ``misses``.
    """
    found, middle = rates(outcomes), medians(outcomes, parameter_aliases)
    values = {name: None if rate is None else rate.share for name, rate in found.items()} | middle
    machines = sorted({outcome.case.machine for outcome in outcomes})
    of_machine = {name: [o for o in outcomes if o.case.machine == name] for name in machines}
    return {
        "schema": SCHEMA,
        "cases": len(outcomes),
        "failed": {case.name: message for case, message in failed.items()},
        "rates": _plain(found),
        "medians": middle,
        "goals": {n: {"goal": goals.of(n), "met": goals.met(n, v)} for n, v in values.items() if goals.of(n)},
        "machines": {
            name: {"cases": len(own), "rates": _plain(rates(own)), "medians": medians(own, parameter_aliases)}
            for name, own in of_machine.items()
        },
        "misses": [_row(o, parameter_aliases) for o in outcomes if not mark(o).right],
    }


def cases_csv(outcomes: Sequence[Outcome], parameter_aliases: Mapping[str, Mapping[str, str]]) -> str:
    """One row a case."""
    text, rows = io.StringIO(), [_row(outcome, parameter_aliases) for outcome in outcomes]
    writer = csv.DictWriter(text, list(rows[0]) if rows else [], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def answers(outcomes: Sequence[Outcome], effects: Mapping[str, Effect]) -> Confusion:
    """The confusion matrix by effect, sites left out: none, one effect, or one outside of the catalogue."""
    pairs = []
    for outcome in outcomes:
        kind = outcome.case.kind
        if kind == "several":
            continue
        truth = outcome.truths[0].partition("@")[0] if kind == "single" else kind
        found = outcome.found[0][0].partition("@")[0] if outcome.found else outcome.verdict
        pairs.append((truth, found, mark(outcome).right))
    ordered = sorted(effects.values(), key=lambda effect: (FAMILIES.index(effect.family), effect.name))
    return confusion(pairs, [*(effect.name for effect in ordered), "outside", "none", "unexplained"])


def _plain(found: Mapping[str, Any]) -> dict[str, Any]:
    return {name: None if rate is None else asdict(rate) for name, rate in found.items()}


def _row(outcome: Outcome, parameter_aliases: Mapping[str, Mapping[str, str]]) -> dict[str, Any]:
    case, judged = outcome.case, mark(outcome)
    errors = parameter_errors(outcome, parameter_aliases)
    return {
        "machine": case.machine,
        "kind": case.kind,
        "hidden": case.hidden,
        "truth": " + ".join(outcome.truths) or case.kind,
        "instruments": case.instruments,
        "seed": case.seed,
        "verdict": outcome.verdict,
        "answer": " + ".join(" or ".join(group) for group in outcome.found),
        "right": judged.right,
        "top_3": judged.top_3,
        "false": judged.false,
        "chi2_base": outcome.chi2_base,
        "chi2": outcome.chi2,
        "parameter_error": max(errors.values(), default=None),
        "remaining": outcome.remaining,
        "cpu_s": outcome.cpu,
        "wall_s": outcome.wall,
        "cause": cause(outcome),
    }
