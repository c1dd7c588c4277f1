"""How far long work has come: a bar on a terminal, a line now and then where there is none."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    TaskProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

_EVERY = 30.0  # s between two lines

Show = Callable[[float, str], None]
"""Gets how much is done, and what is being done."""


@contextmanager
def progress(total: float, done: float = 0.0) -> Iterator[Show]:
    """The terminal, or lines for a pipe or a file, which come out as they are printed.

    Args:
        total: how much there is to do.
        done: how much of it was done before.
    """
    console = Console()
    if not console.is_terminal:
        yield _lines(console, total, done)
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
    with Progress(*columns, TextColumn("left"), TimeRemainingColumn(), console=console, transient=True) as bar:
        task = bar.add_task("", total=total)
        bar.update(task, completed=done)
        yield lambda completed, text: bar.update(task, completed=completed, description=text)


def _lines(console: Console, total: float, done: float) -> Show:
    began = last = time.monotonic()

    def show(completed: float, text: str) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last < _EVERY or completed >= total:
            return
        last = now
        rest = (now - began) * (total - completed) / max(completed - done, 1e-9 * total)
        said = f"{text}: {completed / total:.0%}, {rest:.0f} s left" if rest < 90 else ""
        said = said or f"{text}: {completed / total:.0%}, {rest / 60:.0f} min left"
        console.print(said, markup=False, highlight=False, soft_wrap=True)

    return show
