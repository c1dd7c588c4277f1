"""What is said of logs before anything is fitted."""

from collections.abc import Sequence

from rich.console import Console

from dr_lab.comparison.fault_notes import faults_markdown
from dr_lab.comparison.silent_notes import silent_markdown
from dr_lab.reports.gap_entries import NoteEntry
from dr_lab.reports.screen import ScreenMarkdown


def say_first(notes: Sequence[NoteEntry]) -> None:
    """Print the faults among some notes, and what the model has and no log names."""
    if told := "\n\n".join(part for part in (faults_markdown(notes), silent_markdown(notes)) if part):
        Console().print(ScreenMarkdown(told))
