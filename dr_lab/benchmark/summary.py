"""What all outcomes come to: the report for programs, rows for spreadsheets, and the confusion matrix."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict

from dr_lab.benchmark.case import Case
from dr_lab.benchmark.causes import cause
from dr_lab.benchmark.outcome import Outcome
from dr_lab.benchmark.rates import medians, parameter_errors, rates
from dr_lab.benchmark.score import mark
from dr_lab.benchmark.scoring import Aliases, Scoring
from dr_lab.effects.effect import FAMILIES, Effect
from dr_lab.recorders.confusion import Confusion, confusion
from dr_lab.reports.benchmark import SCHEMA, BenchmarkReport, CaseEntry, GoalEntry, MachineEntry
from dr_lab.reports.csv_rows import rows_csv
from dr_lab.reports.plain import finite


def benchmark_report(outcomes: Sequence[Outcome], failed: Mapping[Case, str], scoring: Scoring) -> BenchmarkReport:
    """The report as it is written.

    A case that failed is in no rate. While there is one, no goal is judged: it might have been missed there.

    Args:
        outcomes: the judged cases.
        failed: cases that ended with an error, and what it said.
        scoring: by what answers are scored.
    """
    goals, aliases = scoring.goals, scoring.parameter_aliases
    found, middle = rates(outcomes, aliases), medians(outcomes, aliases)
    values = {name: None if rate is None else rate.share for name, rate in found.items()} | middle
    machines = sorted({outcome.case.machine for outcome in outcomes})
    of_machine = {name: [o for o in outcomes if o.case.machine == name] for name in machines}
    return finite(
        BenchmarkReport(
            schema=SCHEMA,
            cases=len(outcomes),
            failed={case.name: message for case, message in failed.items()},
            rates=found,
            medians=middle,
            goals={
                name: GoalEntry(goals.of(name), None if failed else goals.met(name, value))
                for name, value in values.items()
                if goals.of(name)
            },
            machines={name: _machine(own, aliases) for name, own in of_machine.items()},
            misses=tuple(_entry(outcome, aliases) for outcome in outcomes if not mark(outcome).right),
        )
    )


def cases_csv(outcomes: Sequence[Outcome], parameter_aliases: Aliases) -> str:
    """One row a case."""
    return rows_csv([asdict(_entry(outcome, parameter_aliases)) for outcome in outcomes])


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


def _machine(outcomes: Sequence[Outcome], parameter_aliases: Aliases) -> MachineEntry:
    return MachineEntry(len(outcomes), rates(outcomes, parameter_aliases), medians(outcomes, parameter_aliases))


def _entry(outcome: Outcome, parameter_aliases: Aliases) -> CaseEntry:
    case, judged = outcome.case, mark(outcome)
    errors = parameter_errors(outcome, parameter_aliases)
    return CaseEntry(
        machine=case.machine,
        kind=case.kind,
        hidden=case.hidden,
        truth=" + ".join(outcome.truths) or case.kind,
        instruments=case.instruments,
        seed=case.seed,
        verdict=outcome.verdict,
        answer=" + ".join(" or ".join(group) for group in outcome.found),
        right=judged.right,
        top_3=judged.top_3,
        false=judged.false,
        chi2_base=outcome.chi2_base,
        chi2=outcome.chi2,
        parameter_error=max(errors.values(), default=None),
        remaining=outcome.remaining,
        cpu_s=outcome.cpu,
        wall_s=outcome.wall,
        cause=cause(outcome),
    )
