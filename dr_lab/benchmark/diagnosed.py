"""One case, from its logs to the answer that is scored."""

import time
from dataclasses import replace

from dr_lab.benchmark.case import Case
from dr_lab.benchmark.equivalence import TruthClasses
from dr_lab.benchmark.observed import Compose, observe
from dr_lab.benchmark.outcome import Outcome, Standing
from dr_lab.comparison.climbing import climbed
from dr_lab.comparison.entries import remaining
from dr_lab.comparison.study import Study
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.climb_watch import Silence
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.diagnosis.search.rung import Rung
from dr_lab.diagnosis.search.uncertainty import known


def diagnose_case(case: Case, compose: Compose, classes: TruthClasses) -> Outcome:
    """Record, diagnose and, where the answer is not exactly the truth, look for what is equivalent to it.

    Machines with several effects are climbed one rung further than the truth goes; all others are judged by their
    first ranking, as `dr-lab diagnose` does.

    Args:
        case: what to diagnose.
        compose: gives the arguments of a verb, built from its name and overrides.
        classes: finds the equivalence classes by which the answer is scored, or refuses the case with a ConfigError.
    """
    classes.require(case, compose)
    observed, begin = observe(case, compose), (time.process_time(), time.monotonic())
    truths = observed.truths if case.kind != "outside" else ()
    most = len(truths) + 1 if case.kind == "several" else 0
    study, ladder = climbed(observed.study, observed.effects, most=most, watch=Silence())
    observed = replace(observed, study=study)
    cpu, wall = time.process_time() - begin[0], time.monotonic() - begin[1]
    last = ladder.models[-1]
    verdict = ladder.verdict(study.bench.evidence)
    found = _found(ladder) if verdict != "unexplained" else []
    own = {truth: values for truth in truths if (values := _own_values(study, ladder, truth))}
    return Outcome(
        case=case,
        truths=observed.truths,
        verdict=verdict,
        found=found,
        absorbed=list(ladder.absorbed),
        ranking=[c.effect.label for c in _ordered(ladder.rungs[0])],
        standing={truth: standing for truth in truths if (standing := _standing(ladder, truth))},
        classes=classes.of(case, truths, found, observed, compose),
        magnitudes=observed.magnitudes,
        fitted={truth: {name: value for name, (value, _) in values.items()} for truth, values in own.items()},
        stated={truth: {name: std for name, (_, std) in values.items()} for truth, values in own.items()},
        chi2_base=ladder.base.held_out.chi2,
        chi2=last.held_out.chi2,
        remaining=remaining(last.held_out, study.bench.evidence).status,
        cpu=cpu,
        wall=wall,
    )


def _found(ladder: Ladder) -> list[list[str]]:
    """What was found, each with what the data cannot separate from it."""
    labels = [step.fitted_model.model.effects[-1].label for step in ladder.steps]
    rivals = [[c.effect.label for c in step.rivals] for step in ladder.steps]
    return [[label, *others] for label, others in zip(labels, rivals, strict=True)]


def _ordered(rung: Rung) -> list[Candidate]:
    """The verdict's effects first, then by evidence, as reports show them."""
    order = {label: place for place, label in enumerate(rung.verdict.effects)}
    return sorted(rung.ranking, key=lambda c: order.get(c.effect.label, len(order)))


def _standing(ladder: Ladder, truth: str) -> Standing | None:
    """How a truth stood in the last ranking that it was part of; None where it was no candidate."""
    for rung in reversed(ladder.rungs):
        for place, candidate in enumerate(_ordered(rung), start=1):
            if candidate.effect.label == truth:
                return Standing(
                    place=place,
                    fitted=candidate.fitted,
                    promised=candidate.predicted,
                    chi2=candidate.fitted_model.held_out.chi2,
                    evidence=candidate.gain.total,
                    evidence_low=candidate.gain.total_low,
                    gap=candidate.gain.gap,
                    status=rung.verdict.status[truth],
                )
    return None


def _own_values(study: Study, ladder: Ladder, truth: str) -> dict[str, tuple[float, float]]:
    """Fitted parameters of a truth with their ±, by short name, in the model that the answer leads to.

    Empty if it is not found.
    """
    rivals = [c.fitted_model for c in ladder.steps[0].rivals] if len(ladder.steps) == 1 else []
    for fitted_model in (ladder.models[-1], *rivals):
        if any(effect.label == truth for effect in fitted_model.model.effects):
            found = known(study.bench, fitted_model).estimate
            rows = zip(found.space.names, found.mean.tolist(), found.std.tolist(), strict=True)
            return {k.removeprefix(f"{truth}."): (v, std) for k, v, std in rows if k.startswith(f"{truth}.")}
    return {}
