"""How many threads numerical libraries may use beside those of dr_lab."""

from contextlib import AbstractContextManager

from threadpoolctl import threadpool_limits


def algebra_on_one_thread() -> AbstractContextManager[object]:
    """While it is entered, BLAS and LAPACK of NumPy and SciPy use one thread each.

    The physics has its own threads, one a core, and so have fits side by side. The products of a fit to an arm of seven
    joints are just large enough for OpenBLAS to share them out: its threads then wait for cores that are taken, and a
    product of 0.1 s takes 3 s.
    """
    return threadpool_limits(1, user_api="blas")
