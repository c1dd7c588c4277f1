"""What a benchmark diagnoses."""

import fnmatch
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from dr_lab.benchmark.case import BenchmarkMachine, Case, Cases, expand
from dr_lab.benchmark.equivalence import TruthClasses
from dr_lab.errors import ConfigError, UnknownNameError


@dataclass(frozen=True)
class BenchmarkPlan:
    """What is diagnosed, and how many cases at a time.

    Attributes:
        machines: what can be diagnosed, by name.
        cases: sets of cases.
        only: names of cases, with the wildcards ``*``, ``?`` and ``[05]``; None takes all.
        classes: finds the equivalence classes by which answers are scored.
        processes: cases at a time; None takes every core.

    Raises:
        ConfigError: `processes` is too small.
    """

    machines: Mapping[str, BenchmarkMachine]
    cases: Mapping[str, Cases]
    only: Sequence[str] | None
    classes: TruthClasses
    processes: int | None

    def __post_init__(self) -> None:
        if self.processes is not None and self.processes < 1:
            raise ConfigError(f"processes is {self.processes}; expected at least 1, or null for all cores.")

    @property
    def at_a_time(self) -> int:
        """Cases side by side."""
        return self.processes or len(os.sched_getaffinity(0))

    def chosen(self) -> tuple[Case, ...]:
        """The cases whose names are wanted.

        Raises:
            ConfigError: no case is left.
            UnknownNameError: no case has a wanted name, or a set asks for something hidden that there is not.
        """
        cases = expand(self.cases, self.machines)
        for pattern in self.only or ():
            if not any(fnmatch.fnmatchcase(case.name, pattern) for case in cases):
                raise UnknownNameError("case", pattern, [case.name for case in cases], "the chosen cases (only)")
        return tuple(case for case in cases if self._wants(case))

    def _wants(self, case: Case) -> bool:
        return self.only is None or any(fnmatch.fnmatchcase(case.name, pattern) for pattern in self.only)
