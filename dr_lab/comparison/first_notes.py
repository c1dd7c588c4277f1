"""What is said of logs before anything is fitted."""

from collections.abc import Sequence

from rich.console import Console

from dr_lab.comparison.fault_notes import faults_markdown, lines_markdown
from dr_lab.comparison.silent_notes import silent_markdown
from dr_lab.reports.gap_entries import NoteEntry
from dr_lab.reports.screen import ScreenMarkdown


def say_first(notes: Sequence[NoteEntry]) -> None:
    """Print the faults among some notes, how commands are read, and what the model has and no log names."""
    parts = (faults_markdown(notes), lines_markdown(notes), silent_markdown(notes))
    if told := "\n\n".join(filter(None, parts)):
        Console().print(ScreenMarkdown(told))
