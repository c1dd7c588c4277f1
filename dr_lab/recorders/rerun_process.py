"""The Rerun binary as a process: where it is, which ports it gets, what it complains of."""

import os
import re
import socket
import subprocess
import time
from pathlib import Path
from typing import IO

import rerun_cli

from dr_lab.errors import ConfigError, DrLabError

# Rerun listens on every network by default; a recording is nobody else's business.
LOCAL = "127.0.0.1"
# s: a viewer that has not answered by then never will; a cold start on a slow machine takes up to ten.
START_LIMIT = 60.0
POLL = 0.05
_LAST_PORT = 65535


def viewer_binary() -> str:
    """Path of the viewer itself; the console script `rerun` is a shim that leaves it running when killed.

    Raises:
        DrLabError: the binary is missing from the installed package.
    """
    binary = Path(rerun_cli.__file__).with_name("rerun.exe" if os.name == "nt" else "rerun")
    if not binary.is_file():
        raise DrLabError(
            f"The Rerun viewer is missing at {binary}. Reinstall it: pip install --force-reinstall rerun-sdk."
        )
    return str(binary)


def free_port(wanted: int = 0) -> int:
    """A port of this machine that nobody listens on: the wanted one, or any other where it is taken (0: any).

    Raises:
        ConfigError: there is no such port.
        DrLabError: none is free.
    """
    if not 0 <= wanted <= _LAST_PORT:
        raise ConfigError(f"There is no port {wanted}; give page_port and data_port up to {_LAST_PORT}, 0 for any.")
    for port in (wanted, 0):
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((LOCAL, port))
            except OSError:
                continue
            return probe.getsockname()[1]
    raise DrLabError(f"No port of {LOCAL} is free for the viewer. Close what uses them.")


def await_port(process: subprocess.Popen[bytes], port: int) -> None:
    """Wait until a process answers on a port.

    Raises:
        ConnectionError: it ended, or took too long.
    """
    deadline = time.monotonic() + START_LIMIT
    while time.monotonic() < deadline and process.poll() is None:
        with socket.socket() as probe:
            if probe.connect_ex((LOCAL, port)) == 0:
                return
        time.sleep(POLL)
    raise ConnectionError(f"no answer on port {port}")


def complaint(output: IO[bytes]) -> str:
    """The lines of a viewer's output that say what went wrong, without the stack below them."""
    output.seek(0)
    lines = [line for line in output.read().decode(errors="replace").splitlines() if line.strip()]
    told = [line for line in lines if re.search("error|panicked", line, flags=re.IGNORECASE)]
    return "\n".join((told or lines)[-3:])
