"""Verb `benchmark`: hidden effects of simulated machines, diagnosed as a user would, and scored."""

import fnmatch
import functools
import json
import os
from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markdown import Markdown
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from dr_lab.benchmark.case import BenchmarkMachine, Case, Cases, expand
from dr_lab.benchmark.diagnosed import diagnose_case
from dr_lab.benchmark.equivalence import TruthClasses
from dr_lab.benchmark.observed import Compose
from dr_lab.benchmark.outcome import Outcome
from dr_lab.benchmark.pages import effects_page, machines_page, misses_page, rates_page, report_page
from dr_lab.benchmark.pool import Diagnose, finished, keep, run_cases
from dr_lab.benchmark.score import mark
from dr_lab.benchmark.summary import Goals, answers, cases_csv, summary
from dr_lab.effects.effect import Effect
from dr_lab.errors import ConfigError, DrLabError, UnknownNameError
from dr_lab.files import write_text
from dr_lab.recorders.benchmark_review import write_benchmark_review
from dr_lab.recorders.confusion import confusion_csv, confusion_picture, write_picture
from dr_lab.recorders.look import Look

CASES = "cases"
RESUMES_FROM = CASES  # what a run folder must hold to be resumed


def benchmark(
    machines: Mapping[str, BenchmarkMachine],
    cases: Mapping[str, Cases],
    goals: Goals,
    parameter_aliases: Mapping[str, Mapping[str, str]],
    effects: Mapping[str, Effect],
    classes: TruthClasses,
    recorder: Look,
    only: Sequence[str] | None,
    resume: str | None,
    processes: int | None,
    compose: Compose,
    run_dir: Path,
) -> dict[str, Any]:
    """Diagnose machines whose missing effects are known, and score the answers.

    Args:
        machines: what can be diagnosed, by name.
        cases: sets of cases.
        goals: what the figures should reach.
        parameter_aliases: effect → the plant's name of a parameter → the catalogue's, where they differ.
        effects: the catalogue, for the order of the confusion matrix.
        classes: finds the equivalence classes by which answers are scored.
        recorder: colours of the confusion matrix.
        only: names of cases, with the wildcards ``*``, ``?`` and ``[05]``; None takes all.
        resume: run folder of an interrupted benchmark, whose finished cases are taken over.
        processes: cases at a time; None takes every core.
        compose: gives the arguments of a verb, built from its name and overrides; must be importable in new processes.
        run_dir: the run folder.

    Returns:
        The content of ``benchmark.json``.

    Raises:
        ConfigError: nothing to run, or no run to resume.
        UnknownNameError: no case has a wanted name.
        DrLabError: cases failed; the files of the others are written.
    """
    wanted = _chosen(expand(cases, machines), only)
    folder = run_dir / CASES
    done = _taken_over(resume, wanted)
    keep(folder, done)
    diagnose = functools.partial(diagnose_case, compose=compose, classes=classes)
    failed = _run([case for case in wanted if case not in done], diagnose, done, folder, _process_count(processes))
    outcomes = [done[case] for case in wanted if case in done]
    result = summary(outcomes, failed, goals, parameter_aliases)
    _write(run_dir, result, outcomes, parameter_aliases, effects, recorder)
    if failed:
        errors = "; ".join(dict.fromkeys(failed.values()))
        raise DrLabError(f"{len(failed)} of {len(wanted)} cases failed; report.md lists them. {errors}")
    return result


def _chosen(cases: Sequence[Case], only: Sequence[str] | None) -> tuple[Case, ...]:
    """The cases whose names are wanted."""
    for pattern in only or ():
        if not any(fnmatch.fnmatchcase(case.name, pattern) for case in cases):
            raise UnknownNameError("case", pattern, [case.name for case in cases], "the chosen cases (only)")
    return tuple(c for c in cases if only is None or any(fnmatch.fnmatchcase(c.name, pattern) for pattern in only))


def _taken_over(resume: str | None, cases: Sequence[Case]) -> dict[Case, Outcome]:
    if resume is None:
        return {}
    folder = Path(resume).expanduser() / CASES
    if not folder.is_dir():
        raise ConfigError(f"resume={resume} is no run folder of a benchmark: it has no folder {CASES}/.")
    return finished(folder, cases)


def _process_count(processes: int | None) -> int:
    if processes is not None and processes < 1:
        raise ConfigError(f"processes is {processes}; expected at least 1, or null for all cores.")
    return processes or len(os.sched_getaffinity(0))


def _run(
    cases: Sequence[Case], diagnose: Diagnose, done: dict[Case, Outcome], folder: Path, processes: int
) -> dict[Case, str]:
    """Diagnose what is not done yet, adding to `done`; gives the errors of cases that failed."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    failed: dict[Case, str] = {}
    with Progress(*columns, TextColumn("left"), TimeRemainingColumn(), transient=True) as progress:
        task = progress.add_task("Diagnosing", total=len(cases) + len(done), completed=len(done))
        try:
            with closing(run_cases(cases, diagnose, folder, processes)) as running:
                for case, outcome in running:
                    if isinstance(outcome, Outcome):
                        done[case] = outcome
                    else:
                        failed[case] = outcome
                    progress.console.print(_line(case, outcome), highlight=False, markup=False, soft_wrap=True)
                    progress.advance(task)
        except BaseException:
            progress.console.print(f"{len(done)} cases are done and kept. To go on, add resume={folder.parent}")
            raise
    return failed


def _line(case: Case, outcome: Outcome | str) -> str:
    if isinstance(outcome, str):
        return f"  FAILED  {case.name}: {outcome}"
    answer = " + ".join(" or ".join(group) for group in outcome.found)
    judged = "right" if mark(outcome).right else "WRONG"
    return f"  {judged}  {case.name}: {outcome.verdict} {answer} ({outcome.cpu:.0f} s CPU)"


def _write(
    run_dir: Path,
    result: Mapping[str, Any],
    outcomes: Sequence[Outcome],
    parameter_aliases: Mapping[str, Mapping[str, str]],
    effects: Mapping[str, Effect],
    look: Look,
) -> None:
    """Write the files of the run and print the figures."""
    matrix = answers(outcomes, effects)
    picture = confusion_picture(matrix, look)
    write_text(run_dir / "benchmark.json", json.dumps(result, ensure_ascii=False, indent=2) + "\n")
    write_text(run_dir / "report.md", report_page(result, outcomes, parameter_aliases))
    write_text(run_dir / "cases.csv", cases_csv(outcomes, parameter_aliases))
    write_text(run_dir / "confusion.csv", confusion_csv(matrix))
    write_picture(run_dir / "confusion.png", picture)
    pages = {
        "Figures": f"{rates_page(result)}\n\n{machines_page(result)}",
        "Misses": misses_page(result),
        "Hidden effects": effects_page(outcomes, parameter_aliases),
    }
    write_benchmark_review(run_dir / "review.rrd", picture, pages)
    told = [rates_page(result), machines_page(result), f"Misses:\n\n{misses_page(result)}"]
    Console().print(Markdown("\n\n".join(told)))
