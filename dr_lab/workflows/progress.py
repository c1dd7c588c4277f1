"""Progress of work that tries many candidates."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn


@contextmanager
def candidate_progress() -> Iterator[Callable[[int], Callable[[str], None]]]:
    """Show a bar for each ranking.

    Yields:
        A function that opens a bar over a number of candidates and gives what to call with each label that is done.
    """
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, transient=True) as progress:

        def watch(count: int) -> Callable[[str], None]:
            task = progress.add_task("Trying effects", total=count)

            def done(label: str) -> None:
                progress.update(task, advance=1, description=f"Trying effects: {label}")

            return done

        yield watch
