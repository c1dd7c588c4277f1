"""Recordings served to a browser, for machines without a screen."""

import os
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from dr_lab.errors import DrLabError
from dr_lab.recorders.rerun_process import LOCAL, START_LIMIT, await_port, complaint, free_port, viewer_binary


@dataclass(frozen=True)
class Site:
    """Where a browser finds a recording; both ports are open to this machine alone.

    Attributes:
        page: port of the viewer.
        data: port of the recording.
        process: what serves both.
    """

    page: int
    data: int
    process: subprocess.Popen[bytes]

    @property
    def url(self) -> str:
        """Address to open in a browser."""
        source = quote(f"rerun+http://{LOCAL}:{self.data}/proxy", safe="")
        return f"http://{LOCAL}:{self.page}/?url={source}"

    @property
    def tunnel(self) -> str:
        """Options of ``ssh`` that bring both ports to the machine it is typed on."""
        return " ".join(f"-L {port}:{LOCAL}:{port}" for port in (self.page, self.data))


@contextmanager
def served(paths: Sequence[Path], page_port: int = 0, data_port: int = 0) -> Iterator[Site]:
    """Serve recordings, with the layout they carry, until the block ends.

    Args:
        paths: the recordings.
        page_port: wanted port of the page; another free one where it is taken, any where 0.
        data_port: likewise of the recording.

    Raises:
        DrLabError: the server does not start.
    """
    page, data = free_port(page_port), free_port(data_port)
    command = [viewer_binary(), "--serve-web", "--bind", LOCAL, "--port", str(data), "--web-viewer-port", str(page)]
    quiet = os.environ | {"RUST_LOG": "error", "NO_COLOR": "1"}
    with tempfile.TemporaryFile() as errors:
        process = subprocess.Popen([*command, *map(str, paths)], stdout=subprocess.DEVNULL, stderr=errors, env=quiet)
        try:
            await_port(process, data)
            await_port(process, page)
            yield Site(page, data, process)
        except ConnectionError as error:
            raise DrLabError(f"The viewer cannot be served to a browser:\n{complaint(errors)}") from error
        finally:
            process.terminate()
            process.wait(START_LIMIT)
