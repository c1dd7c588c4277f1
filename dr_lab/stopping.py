"""Ctrl-C and SIGTERM, which no library on the way can make a run forget.

Either raises an exception in the main thread. Some libraries drop it: an extension module that is being imported clears
whatever was raised; OmegaConf, tidying up a list that is half made, raises an error of its own in its place. So what
arrived is also written down, and a run asks for it wherever a new part of its work begins.
"""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class Terminated(BaseException):
    """SIGTERM, on its way up the stack; like Ctrl-C it is no error that anybody may handle."""


RAISED: dict[int, type[BaseException]] = {signal.SIGINT: KeyboardInterrupt, signal.SIGTERM: Terminated}
_arrived: list[int] = []


@contextmanager
def signals_unwind() -> Iterator[None]:
    """Let Ctrl-C, and SIGTERM, which batch systems send, end the block by an exception: files are put in order.

    Raises:
        KeyboardInterrupt: SIGINT arrived; where it is ignored, as in a shell's background job, it stays so.
        Terminated: SIGTERM arrived.
    """

    def stop(number: int, frame: FrameType | None) -> None:
        _arrived.append(number)
        raise RAISED[number]

    wanted = [number for number in RAISED if signal.getsignal(number) is not signal.SIG_IGN]
    before = {number: signal.signal(number, stop) for number in wanted}
    try:
        yield
        stop_if_asked()
    except Exception:
        stop_if_asked()
        raise
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        _arrived.clear()


def stop_if_asked() -> None:
    """Raise what an earlier signal raised, in case that it was dropped.

    Raises:
        KeyboardInterrupt: SIGINT arrived since `signals_unwind` began.
        Terminated: SIGTERM did.
    """
    if _arrived:
        raise RAISED[_arrived[0]] from None


@contextmanager
def until_ctrl_c() -> Iterator[None]:
    """A block that Ctrl-C is meant to end, after which the work goes on."""
    try:
        yield
    except KeyboardInterrupt:
        _arrived.clear()
