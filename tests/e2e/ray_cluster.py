"""Machines of a Ray cluster, played by processes of this one."""

import os
import signal
import subprocess
import time
from pathlib import Path

ATTEMPTS = 3  # Ray gives its agents 15 s to start, which no setting changes and a busy machine may miss
END = 30.0  # s for a machine to leave
STARTED = "block forever"


class Machine:
    """What `ray start --block` makes of a machine.

    Args:
        command: a line for bash.
        environment: of it.
        output: file for what it prints.
    """

    def __init__(self, command: str, environment: dict[str, str], output: Path) -> None:
        for _ in range(ATTEMPTS):
            with output.open("wb") as file:
                self._process = subprocess.Popen(
                    ["bash", "-c", f"exec {command}"], env=environment, stdout=file, stderr=file, start_new_session=True
                )
            while self._process.poll() is None:
                if STARTED in output.read_text(encoding="utf-8"):
                    return
                time.sleep(0.1)
        raise AssertionError(output.read_text(encoding="utf-8"))

    def die(self) -> None:
        """End as a machine that loses power: its raylet is killed, and with it all jobs there."""
        found = Path(f"/proc/{self._process.pid}/task/{self._process.pid}/children").read_text(encoding="ascii").split()
        [raylet] = [int(pid) for pid in found if Path(f"/proc/{pid}/comm").read_text(encoding="ascii") == "raylet\n"]
        os.kill(raylet, signal.SIGKILL)

    def leave(self) -> None:
        """End as with Ctrl-C."""
        self._process.terminate()
        try:
            self._process.wait(END)
        except subprocess.TimeoutExpired:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()
