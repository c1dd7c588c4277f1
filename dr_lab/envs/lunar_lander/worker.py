"""Landers in another process."""

import os
import signal
import subprocess
import sys
import weakref
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any

from dr_lab.envs.lunar_lander.lander import Landers
from dr_lab.errors import DrLabError


class LanderWorker:
    """Calls methods of `Landers` in a process of its own, which ends with this object or with this process.

    The process is a new Python that imports little: a fork would inherit the threads' locks of torch and MuJoCo.

    Args:
        count: number of landers.
    """

    def __init__(self, count: int) -> None:
        self._connection, theirs = Pipe()
        found = os.pathsep.join(filter(None, sys.path))
        command = [sys.executable, "-m", __name__, str(theirs.fileno()), str(count)]
        self._process = subprocess.Popen(
            command, pass_fds=[theirs.fileno()], env={**os.environ, "PYTHONPATH": found}, stdin=subprocess.DEVNULL
        )
        theirs.close()
        weakref.finalize(self, _end, self._connection, self._process)

    def ask(self, method: str, *arguments: Any) -> None:  # noqa: ANN401 (whatever the method takes)
        """Call a method of the landers; other work may be done until its `answer`."""
        try:
            self._connection.send((method, arguments))
        except OSError as error:
            raise self._lost() from error

    def answer(self) -> Any:  # noqa: ANN401 (whatever the method gives)
        """What the method gave.

        Raises:
            DrLabError: the process has ended.
        """
        try:
            answer = self._connection.recv()
        except (EOFError, OSError) as error:
            raise self._lost() from error
        if isinstance(answer, Exception):
            raise answer
        return answer

    def _lost(self) -> DrLabError:
        return DrLabError(
            f"A process that plays landers has ended, with exit code {self._process.wait()}. Its message stands above; "
            "if there is none, the machine may be out of memory. Resume the run, or give threads=1, which needs "
            "no other process."
        )


def _end(connection: Connection, process: subprocess.Popen[bytes]) -> None:
    connection.close()
    process.wait()


def serve(connection: Connection, count: int) -> None:
    """Answer calls until the other side is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all processes of a terminal; that one decides
    landers = Landers(count)
    while True:
        try:
            method, arguments = connection.recv()
        except EOFError:
            return
        try:
            answer = getattr(landers, method)(*arguments)
        except Exception as error:  # raised on the other side
            answer = error
        connection.send(answer)


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])), int(sys.argv[2]))
