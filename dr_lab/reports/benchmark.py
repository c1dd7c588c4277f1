"""The report of benchmark; `benchmark.schema.json` says what each key means."""

from collections.abc import Mapping
from dataclasses import dataclass

from dr_lab.reports.plain import Number

SCHEMA = "dr_lab/benchmark/1"


@dataclass(frozen=True)
class Rate:
    """How often something happened, and Wilson's 95 % interval of its share (Wilson 1927)."""

    count: int
    of: int
    share: float
    low: float
    high: float


@dataclass(frozen=True)
class GoalEntry:
    """What a figure should reach, and whether it does; None where the figure is not known or a case failed."""

    goal: str
    met: bool | None


@dataclass(frozen=True)
class MachineEntry:
    """The figures of one machine."""

    cases: int
    rates: Mapping[str, Rate | None]
    medians: Mapping[str, Number]


@dataclass(frozen=True)
class CaseEntry:
    """One case, what was answered, and how that is judged."""

    machine: str
    kind: str
    hidden: str
    truth: str
    instruments: str
    seed: int
    verdict: str
    answer: str
    right: bool
    top_3: bool
    false: bool
    chi2_base: Number
    chi2: Number
    parameter_error: Number
    remaining: str
    cpu_s: Number
    wall_s: Number
    cause: str


@dataclass(frozen=True)
class BenchmarkReport:
    """What all cases of a benchmark come to; `benchmark.json` holds it."""

    schema: str
    cases: int
    failed: Mapping[str, str]
    rates: Mapping[str, Rate | None]
    medians: Mapping[str, Number]
    goals: Mapping[str, GoalEntry]
    machines: Mapping[str, MachineEntry]
    misses: tuple[CaseEntry, ...]
