"""Cases and outcomes of the benchmark whose judgement is known, and a diagnosis that only pretends."""

import os
from pathlib import Path
from typing import Any

from dr_lab.benchmark.case import Case, Kind
from dr_lab.benchmark.outcome import Outcome, Standing
from dr_lab.errors import DataError

A, B, C = "coulomb_friction@arm", "spring@arm", "actuator_delay@motor"
STANDING = Standing(
    place=2,
    fitted=True,
    promised=0.4,
    chi2=1.3,
    evidence=300.0,
    evidence_low=-5.0,
    gap=0.6,
    status="rejected",
)


def case_of(kind: Kind, *truths: str, seed: int = 0) -> Case:
    hidden = "-".join(label.partition("@")[0] for label in truths) or kind
    return Case("crank", kind, hidden, "encoders", seed, ("plant=crank",), ("model=crank",))


def outcome_of(kind: Kind, *truths: str, seed: int = 0, **answer: object) -> Outcome:
    fields: dict[str, Any] = dict(  # noqa: C408
        case=case_of(kind, *truths, seed=seed),
        truths=truths,
        verdict="none",
        found=[],
        absorbed=[],
        ranking=[A, B, C],
        standing=dict.fromkeys(truths, STANDING),
        classes={},
        magnitudes={},
        fitted={},
        chi2_base=50.0,
        chi2=1.01,
        remaining="at_floor",
        cpu=10.0,
        wall=5.0,
    )
    fields.update(answer)
    return Outcome(**fields)


def named(*truths: str, answer: str = A, seed: int = 0, **more: object) -> Outcome:
    return outcome_of("single", *truths, seed=seed, verdict="named", found=[[answer]], **more)


def pretended(case: Case, log: Path) -> Outcome:
    """Answers at once what the seed says and notes in a file that it was asked; 12 has no finite χ², 13 fails."""
    with log.open("a") as file:
        file.write(f"{case.name} {os.environ['OMP_NUM_THREADS']}\n")
    if case.seed == 13:
        raise DataError("no logs")
    return outcome_of(case.kind, seed=case.seed, chi2=float("inf") if case.seed == 12 else 1.0 + case.seed)
