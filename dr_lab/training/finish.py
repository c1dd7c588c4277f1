"""The end of the verbs that train and evaluate: the run folder's files, and the page on the screen."""

from dataclasses import replace
from pathlib import Path

from rich.console import Console

from dr_lab.envs.environment import Environment
from dr_lab.files import write_text
from dr_lab.html.training_page import write_training_page
from dr_lab.recorders.look import Look
from dr_lab.recorders.training_review import TrainingRecord, write_training_review
from dr_lab.reports.evaluate import EvaluateReport
from dr_lab.reports.json_file import write_json
from dr_lab.reports.page import Page
from dr_lab.reports.screen import ScreenMarkdown
from dr_lab.reports.train import TrainReport
from dr_lab.training.episodes import keep_episodes


def finish(
    run_dir: Path,
    report: TrainReport | EvaluateReport,
    page: Page,
    environment: Environment,
    record: TrainingRecord,
    look: Look,
) -> None:
    """Write ``report.json``, ``report.md``, ``report.html``, ``episodes.mcap`` and ``review.rrd``, and print the page.

    Args:
        run_dir: the run folder.
        report: what was found.
        page: the same for a person.
        environment: what shows the episodes.
        record: what the recording holds beside the page.
        look: how it looks.
    """
    write_json(run_dir / "report.json", report)
    text = page.markdown()
    write_text(run_dir / "report.md", text)
    write_training_page(run_dir / "report.html", page, report, record)
    keep_episodes(run_dir, environment, record.episodes)
    write_training_review(run_dir / "review.rrd", replace(record, pages={"Report": text}), look)
    Console().print(ScreenMarkdown(text))
