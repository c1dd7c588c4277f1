"""Verb `benchmark`: hidden effects of simulated machines, diagnosed as a user would, and scored."""

import functools
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from dr_lab.benchmark.case import Case
from dr_lab.benchmark.diagnosed import diagnose_case
from dr_lab.benchmark.observed import Compose
from dr_lab.benchmark.outcome import Outcome
from dr_lab.benchmark.pages import SAID, effects_page, machines_page, misses_page, rates_page, report_page
from dr_lab.benchmark.plan import BenchmarkPlan
from dr_lab.benchmark.pool import Diagnose, finished, keep, run_cases
from dr_lab.benchmark.score import mark
from dr_lab.benchmark.scoring import Scoring
from dr_lab.benchmark.summary import answers, benchmark_report, cases_csv
from dr_lab.errors import ConfigError, DrLabError
from dr_lab.files import write_text
from dr_lab.html.benchmark_page import write_benchmark_page
from dr_lab.recorders.benchmark_review import write_benchmark_review
from dr_lab.recorders.confusion import confusion_csv, confusion_picture, write_picture
from dr_lab.recorders.look import Look
from dr_lab.reports.benchmark import BenchmarkReport
from dr_lab.reports.json_file import write_json
from dr_lab.reports.screen import ScreenMarkdown
from dr_lab.reports.typed import typed

CASES = "cases"
RESUMES_FROM = CASES  # what a run folder must hold to be resumed
# Keys that may be others in a run that is gone on with: a case tells of itself what was asked, and goals are judged
# anew. By which classes an answer is scored (`classes`) is found out once, beside the diagnosis.
MAY_DIFFER = (
    *("cases", "machines", "only", "draw", "spread", "shares", "kept", "noises"),
    *("goals", "parameter_aliases", "effects", "recorder", "processes"),
)


def benchmark(
    plan: BenchmarkPlan, scoring: Scoring, recorder: Look, resume: str | None, compose: Compose, run_dir: Path
) -> BenchmarkReport:
    """Diagnose machines whose missing effects are known, and score the answers.

    Args:
        plan: what is diagnosed.
        scoring: by what the answers are scored.
        recorder: colours of the confusion matrix.
        resume: run folder of an interrupted benchmark, whose finished cases are taken over.
        compose: gives the arguments of a verb, built from its name and overrides; must be importable in new processes.
        run_dir: the run folder.

    Returns:
        The content of ``benchmark.json`` (schema dr_lab/benchmark/1).

    Raises:
        ConfigError: nothing to run, or no run to resume.
        UnknownNameError: no case has a wanted name.
        DrLabError: cases failed; the files of the others are written.
    """
    wanted, folder = plan.chosen(), run_dir / CASES
    done = _taken_over(resume, wanted)
    keep(folder, done)
    diagnose = functools.partial(diagnose_case, compose=compose, classes=plan.classes)
    failed = _run([case for case in wanted if case not in done], diagnose, done, folder, plan.at_a_time)
    outcomes = [done[case] for case in wanted if case in done]
    report = benchmark_report(outcomes, failed, scoring)
    _write(run_dir, report, outcomes, scoring, recorder)
    if failed:
        errors = "; ".join(dict.fromkeys(failed.values()))
        raise DrLabError(f"{len(failed)} of {len(wanted)} cases failed; report.md lists them. {errors}")
    return report


def _taken_over(resume: str | None, cases: Sequence[Case]) -> dict[Case, Outcome]:
    if resume is None:
        return {}
    folder = Path(resume).expanduser() / CASES
    if not folder.is_dir():
        raise ConfigError(f"resume={resume} is no run folder of a benchmark: it has no folder {CASES}/.")
    return finished(folder, cases)


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
            told = f"{len(done)} cases are done and kept. To go on, add {typed('resume', folder.parent)}"
            progress.console.print(told, markup=False, soft_wrap=True)
            raise
    return failed


def _line(case: Case, outcome: Outcome | str) -> str:
    if isinstance(outcome, str):
        return f"  FAILED  {case.name}: {outcome}"
    answer = " + ".join(" or ".join(group) for group in outcome.found)
    judged = "right" if mark(outcome).right else "WRONG"
    return f"  {judged}  {case.name}: {outcome.verdict} {answer} ({outcome.cpu:.0f} s CPU)"


def _write(run_dir: Path, report: BenchmarkReport, outcomes: Sequence[Outcome], scoring: Scoring, look: Look) -> None:
    """Write the files of the run and print the figures."""
    aliases, matrix = scoring.parameter_aliases, answers(outcomes, scoring.effects)
    picture = confusion_picture(matrix, look)
    write_json(run_dir / "benchmark.json", report)
    page = report_page(report, outcomes, aliases)
    write_text(run_dir / "report.md", page.markdown())
    write_benchmark_page(run_dir / "report.html", page, report, SAID, matrix)
    write_text(run_dir / "cases.csv", cases_csv(outcomes, aliases))
    write_text(run_dir / "confusion.csv", confusion_csv(matrix))
    write_picture(run_dir / "confusion.png", picture)
    pages = {
        "Figures": f"{rates_page(report)}\n\n{machines_page(report)}",
        "Misses": misses_page(report),
        "Hidden effects": effects_page(outcomes, aliases),
    }
    write_benchmark_review(run_dir / "review.rrd", picture, pages)
    Console().print(ScreenMarkdown(f"{pages['Figures']}\n\nMisses:\n\n{pages['Misses']}"))
