"""How a job's figures stand while it runs, told to whoever watches it: a study, which may give it up."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar

Watcher = Callable[[int, Mapping[str, float]], None]

_watcher: ContextVar[Watcher | None] = ContextVar("watcher", default=None)


class Pruned(Exception):  # noqa: N818  no error: the study has seen enough of this job
    """The study gives up the job that runs."""


def tell(step: int, figures: Mapping[str, float]) -> None:
    """Say how a job stands; a workflow calls it now and then, outside of studies to no effect.

    Args:
        step: grows from call to call, e.g. the iteration.
        figures: by name.

    Raises:
        Pruned: the job is to end.
    """
    watcher = _watcher.get()
    if watcher is not None:
        watcher(step, figures)


@contextmanager
def told_to(watcher: Watcher) -> Iterator[None]:
    """Let `tell` reach a watcher while a block runs.

    Args:
        watcher: gets step and figures; may raise `Pruned`.
    """
    token = _watcher.set(watcher)
    try:
        yield
    finally:
        _watcher.reset(token)
