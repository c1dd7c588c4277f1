"""The same work on many items, one thread each."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
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


def one_behind_another(
    places: Sequence[int],
    before: Mapping[int, int],
    work: Callable[[int, _Out | None], _Out],
    threads: int,
    stop: Event,
) -> list[_Out]:
    """The same for places, some of which wait for what the work gives for an earlier one, which their work is given.

    Args:
        places: those that others wait for begin before these, the others in this order.
        before: which place one waits for; one that is not among the places has nothing to give.
        work: looks at `stop` now and then.
        threads: as for `side_by_side`.
        stop: as there.
    """
    made = {place: Future[_Out]() for place in places}
    row = dict[int, None]()

    def line_up(place: int) -> None:
        if before.get(place, -1) in made:
            line_up(before[place])
        row[place] = None

    def run(place: int) -> _Out:
        try:
            waited = made.get(before.get(place, -1))
            made[place].set_result(work(place, None if waited is None else waited.result()))
        except BaseException as error:  # those that wait for it end, too
            made[place].set_exception(error)
            raise
        return made[place].result()

    for place in places:
        line_up(place)
    side_by_side(list(row), run, threads, stop)
    return [made[place].result() for place in places]
