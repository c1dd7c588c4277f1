"""The same work on many items, one thread each."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from threading import Event
from typing import TypeVar

_In = TypeVar("_In")
_Out = TypeVar("_Out")


def side_by_side(items: Sequence[_In], work: Callable[[_In], _Out], threads: int, stop: Event) -> list[_Out]:
    """What the work gives for each item, in their order.

    Args:
        items: what is worked on.
        work: looks at `stop` now and then.
        threads: how many at a time.
        stop: is set where one fails or on Ctrl-C, which is then raised.
    """
    with ThreadPoolExecutor(threads) as pool:
        jobs = [pool.submit(work, item) for item in items]
        try:
            for job in as_completed(jobs):
                job.result()
        except BaseException:
            stop.set()
            pool.shutdown(cancel_futures=True)
            raise
    return [job.result() for job in jobs]
