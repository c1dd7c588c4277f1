"""What a verb tells while it works: a bar for each phase on a terminal, a line for each where there is none."""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from threading import Lock
from typing import Protocol

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    Task,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from dr_lab.diagnosis.search.climb_watch import ClimbWatch
from dr_lab.reports.quantity import number
from dr_lab.reports.screen import ScreenMarkdown

_PARTS = 4  # of a ranking that get a line each
_NAMED = 3  # most effects that are told by their names
_ANEW = "The model itself was found to fit better: trying all anew"
_LONGEST = 10.0  # s between two lines, as far as candidates are done in them


class Screen(ClimbWatch, Protocol):
    """Where a verb tells its user what it does and what it found."""

    def show(self, markdown: str) -> None:
        """Print what stays on the screen."""
        ...


@contextmanager
def screen() -> Iterator[Screen]:
    """The terminal, or lines for a pipe or a file, which come out as they are printed."""
    console = Console()
    if not console.is_terminal:
        yield _Lines(console)
        return
    columns = (TextColumn("{task.description}"), BarColumn(), _Count(), TimeElapsedColumn(), _Left())
    with Progress(*columns, console=console, transient=True) as bars:
        yield _Bars(bars)


class _Lines:
    def __init__(self, console: Console) -> None:
        self._console = console

    def phase(self, text: str) -> None:
        self._line(f"{text} …")

    def ranking(self, labels: Sequence[str]) -> Callable[[str], None]:
        self.phase(_trying(labels))
        count = len(labels)
        tried, told, began = 0, 0, time.monotonic()
        last, lock = began, Lock()

        def done(label: str) -> None:
            nonlocal tried, told, last, began
            with lock:  # candidates are tried side by side
                if tried == count:
                    self.phase(_ANEW)
                    tried, told, began = 0, 0, time.monotonic()
                tried += 1
                due = tried * _PARTS // count > told * _PARTS // count or time.monotonic() - last >= _LONGEST
                if due and count > 1:
                    told, last = tried, time.monotonic()
                    left = (last - began) * (count - tried) / tried if tried * _PARTS >= count else 0.0
                    self._line(f"  {tried} of {count} tried, the last {label}{_left(left)}")

        return done

    def found(self, labels: Sequence[str], before: float, after: float) -> None:
        self._line(_so_far(labels, before, after))

    def show(self, markdown: str) -> None:
        self._console.print()
        self._console.print(ScreenMarkdown(markdown))
        self._console.print()

    def _line(self, text: str) -> None:
        self._console.print(text, markup=False, highlight=False, soft_wrap=True)


class _Bars:
    def __init__(self, bars: Progress) -> None:
        self._bars = bars

    def phase(self, text: str) -> None:
        self._begin(text, None)

    def ranking(self, labels: Sequence[str]) -> Callable[[str], None]:
        count = len(labels)
        task, tried = self._begin(_trying(labels), count), 0

        def done(label: str) -> None:
            nonlocal tried
            if tried == count:
                tried = 0
                self._bars.reset(task)
            tried += 1
            self._bars.update(task, advance=1, description=f"Trying effects: {label}")

        return done

    def found(self, labels: Sequence[str], before: float, after: float) -> None:
        self._bars.console.print(_so_far(labels, before, after), markup=False, highlight=False, soft_wrap=True)

    def show(self, markdown: str) -> None:
        self._bars.console.print(ScreenMarkdown(markdown))

    def _begin(self, text: str, total: int | None) -> TaskID:
        for task in self._bars.task_ids:
            self._bars.remove_task(task)
        return self._bars.add_task(text, total=total)


class _Count(MofNCompleteColumn):
    """Nothing for a phase whose end is not counted."""

    def render(self, task: Task) -> Text:
        return super().render(task) if task.total is not None else Text("")


class _Left(TimeRemainingColumn):
    """The time that a phase still takes if it goes on as fast; nothing for one whose end is not counted."""

    def render(self, task: Task) -> Text:
        return Text(_left(task.time_remaining or 0.0).removeprefix("; "))


def _left(seconds: float) -> str:
    """The most that is left, in words; nothing where it is less than a second. What takes longest is tried first."""
    if seconds < 1:
        return ""
    return f"; {seconds:.0f} s left at most" if seconds < 90 else f"; {seconds / 60:.0f} min left at most"


def _trying(labels: Sequence[str]) -> str:
    """What is tried: few by their names, such as what was found at one joint at the others."""
    return f"Trying {', '.join(labels) if len(labels) <= _NAMED else f'{len(labels)} effects'}"


def _so_far(labels: Sequence[str], before: float, after: float) -> str:
    if not labels:
        return "So far: nothing that stands"
    return f"So far: {', '.join(labels)}; χ² {number(before)} → {number(after)}, where 1 is the noise floor"
