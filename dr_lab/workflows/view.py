"""The verb `view`: a finished run in the Rerun viewer."""

import getpass
import socket
from pathlib import Path

from dr_lab.recorders.viewer import find_recording, open_viewer
from dr_lab.recorders.web_viewer import served
from dr_lab.stopping import until_ctrl_c


def view(run: str, outputs: str, web: bool, page_port: int, data_port: int) -> None:
    """Show a run's recording, with the layout it carries; returns when the viewer is closed.

    Args:
        run: a run folder, a recording itself, or ``latest`` for the newest below `outputs`.
        outputs: folder that collects the runs.
        web: serve it to a browser, until Ctrl-C, and print the address; needs no screen on this machine.
        page_port: wanted port of the page, for `web`; only this machine can reach it.
        data_port: likewise of what the page shows.

    Raises:
        DrLabError: there is no such run, it has no recording, or the viewer does not start.
    """
    recording = find_recording(run, Path(outputs))
    if not web:
        open_viewer([recording])
        return
    with until_ctrl_c(), served([recording], page_port, data_port) as site:
        print(f"{recording}\n\n  Open        {site.url}")
        print(f"  From afar   ssh {site.tunnel} {getpass.getuser()}@{socket.gethostname()}")
        print("  End         Ctrl-C", flush=True)
        site.process.wait()
