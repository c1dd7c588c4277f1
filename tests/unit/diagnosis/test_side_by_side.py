"""Work side by side, some of which waits for other work."""

import threading
import time

import pytest

from dr_lab.diagnosis.search.side_by_side import one_behind_another, side_by_side


def test_work_comes_back_in_the_order_of_its_items() -> None:
    found = side_by_side([3, 1, 2], lambda k: time.sleep(0.01 * k) or 10 * k, 3, threading.Event())
    assert found == [30, 10, 20]


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_what_waits_is_given_what_it_waited_for(threads: int) -> None:
    """Places 2 and 3 wait for 0, place 4 for one that is not there."""

    def work(place: int, waited: int | None) -> int:
        time.sleep(0.02 if place == 0 else 0.0)
        return 10 * place + (waited or 0) + 1

    found = one_behind_another([0, 1, 2, 3, 4], {2: 0, 3: 0, 4: 7}, work, threads, threading.Event())
    assert found == [1, 11, 22, 32, 41]


@pytest.mark.parametrize("threads", [1, 2])
def test_what_waits_begins_after_what_it_waits_for_in_whichever_order_they_are_given(threads: int) -> None:
    """Place 2 waits for 1, which waits for 0: one thread would wait for ever."""
    begun = list[int]()

    def work(place: int, waited: int | None) -> int:
        begun.append(place)
        return (waited or 0) + 10**place

    assert one_behind_another([2, 1, 0], {2: 1, 1: 0}, work, threads, threading.Event()) == [111, 11, 1]
    assert begun == [0, 1, 2]


@pytest.mark.parametrize("threads", [1, 3])
def test_a_failure_ends_what_waits_for_it(threads: int) -> None:
    stop = threading.Event()

    def work(place: int, waited: int | None) -> int:
        if place == 0:
            raise ValueError("lost")
        return waited or 0

    with pytest.raises(ValueError, match="lost"):
        one_behind_another([0, 1, 2], {1: 0, 2: 0}, work, threads, stop)
    assert stop.is_set()
