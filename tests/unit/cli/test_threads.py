"""Numerical libraries use one thread where dr_lab's own take the cores."""

import scipy.linalg  # noqa: F401  SciPy has a BLAS of its own beside that of NumPy
from threadpoolctl import threadpool_info, threadpool_limits

from dr_lab.cli.threads import algebra_on_one_thread


def threads() -> list[int]:
    return [each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"]


def test_algebra_has_one_thread_for_as_long_as_work_goes_on() -> None:
    with threadpool_limits(2, user_api="blas"):
        before = threads()
        assert before
        with algebra_on_one_thread():
            assert threads() == [1] * len(before)
        assert threads() == before
