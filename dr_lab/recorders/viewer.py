"""Opening recordings: on the screen, and without one for pictures and tests."""

import os
import subprocess
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from rerun.experimental import ViewerClient

from dr_lab.errors import DrLabError
from dr_lab.files import write_bytes
from dr_lab.recorders.branch import TIMELINE
from dr_lab.recorders.rerun_process import LOCAL, POLL, START_LIMIT, await_port, complaint, free_port, viewer_binary
from dr_lab.reports.typed import view_command

_BEGIN = b"RRF"  # of every recording
_UNREAD = frozenset({".csv", ".html", ".json", ".onnx", ".pt", ".xml", ".yaml"})  # files of runs without an importer
# s: until the notes that the viewer shows on starting have faded.
_NOTES_FADE = 6.0


def find_recording(run: str, runs: Path) -> Path:
    """The recording of a run.

    Args:
        run: a run folder, a recording itself, or ``latest``.
        runs: folder below which ``latest`` looks.

    Raises:
        DrLabError: there is no such folder, no recording in it, or a file that is none; the message says what to do.
    """
    if run == "latest":
        found = sorted(runs.rglob("review.rrd"), key=lambda path: path.stat().st_mtime)
        if not found:
            raise DrLabError(f"There is no recording below {runs}. Run dr-lab compare first, or give run=FOLDER.")
        return found[-1]
    path = Path(run).expanduser()
    recording = path / "review.rrd" if path.is_dir() else path
    if not recording.is_file():
        raise DrLabError(f"There is no recording {recording}. Give run=FOLDER of a run, or run=latest.")
    if recording.suffix in _UNREAD:
        raise DrLabError(
            f"{recording} is no recording, and the viewer opens no {recording.suffix} file. Give run=FOLDER of a run, "
            "or run=latest."
        )
    if recording.suffix == ".rrd" and not _begins_as_recording(recording):
        raise DrLabError(
            f"{recording} is no recording: it does not begin as one. Give run=FOLDER of a run, or run=latest; where it "
            "is the file of a run, copy it anew."
        )
    return recording


def _begins_as_recording(path: Path) -> bool:
    """Otherwise the viewer opens, and shows nothing."""
    with path.open("rb") as file:
        return file.read(len(_BEGIN)) == _BEGIN


def open_viewer(paths: Sequence[Path]) -> None:
    """Show recordings in the Rerun viewer, with the layout they carry; returns when its window is closed.

    Args:
        paths: recordings, or any file that Rerun opens.

    Raises:
        DrLabError: a file is missing, or the viewer does not start, e.g. because there is no display.
    """
    _require_files(paths)
    command = [*_command("auto"), *map(str, paths)]
    with tempfile.TemporaryFile() as errors:
        quiet = os.environ | {"RUST_LOG": "error", "NO_COLOR": "1"}
        code = subprocess.run(command, stderr=errors, env=quiet, check=False).returncode
        if code != 0:
            raise DrLabError(
                f"The viewer ended with code {code}:\n{complaint(errors)}\n"
                "On a machine without a screen, show it in a browser instead: "
                f"{view_command(paths[0])} web=true"
            )


def _require_files(paths: Sequence[Path]) -> None:
    for path in paths:
        if not path.is_file():
            raise DrLabError(f"There is no file {path} to show.")


@contextmanager
def headless_viewer(width: int = 1600, height: int = 900) -> Iterator[ViewerClient]:
    """A viewer without a window, which draws in software where there is no graphics card; closed at the end.

    Args:
        width: of the window it would have, points.
        height: likewise.

    Raises:
        DrLabError: the viewer does not start, e.g. because there is no Vulkan driver.
    """
    port = free_port()
    command = [*_command(str(port)), "--headless", "--window-size", f"{width}x{height}"]
    with tempfile.TemporaryFile() as errors:
        colourless = os.environ | {"NO_COLOR": "1"}
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors, env=colourless)
        try:
            await_port(process, port)
            yield ViewerClient.connect(f"rerun+http://{LOCAL}:{port}/proxy")
        except ConnectionError as error:
            # It listens before it looks for a graphics driver, so a missing one shows in whichever call comes first.
            raise DrLabError(
                f"The viewer does not run without a screen:\n{complaint(errors)}\n"
                "It needs a Vulkan driver, on Debian: apt-get install libvulkan1 mesa-vulkan-drivers."
            ) from error
        finally:
            process.terminate()
            process.wait(START_LIMIT)


def show(viewer: ViewerClient, recording: Path, at: float | None = None) -> None:
    """Open a recording in a viewer, wait until it is loaded, and stop at a time in s; None leaves that to its layout.

    Raises:
        DrLabError: it does not load, or has no times in s.
    """
    viewer.open(str(recording.resolve()))
    deadline = time.monotonic() + START_LIMIT
    while (state := viewer.get_state()).loading or not state.views:
        if time.monotonic() > deadline:
            raise DrLabError(f"The viewer does not finish loading {recording}.")
        time.sleep(POLL)
    if at is None:
        return
    timelines = [timeline.name for each in state.recordings for timeline in each.timelines]
    if TIMELINE not in timelines:
        raise DrLabError(
            f"{recording} has no timeline {TIMELINE!r}, to stop {at:g} s after its start; it has "
            f"{', '.join(timelines) or 'none'}. Leave the time out."
        )
    viewer.set_time(TIMELINE, duration=at, play_state="paused")


def screenshot(recording: Path, picture: Path, at: float | None = None, width: int = 1600, height: int = 900) -> None:
    """Write a PNG of a recording as the viewer shows it.

    Args:
        recording: the file to open.
        picture: the PNG to write.
        at: time on the timeline ``t`` in s; None shows what the viewer shows first, as of training its last iteration.
        width: of the window, points, each a pixel of the picture.
        height: likewise.

    Raises:
        DrLabError: there is no recording, the viewer does not start, the recording has no times in s, or the picture
            cannot be written.
    """
    _require_files([recording])
    with headless_viewer(width, height) as viewer:
        show(viewer, recording, at)
        time.sleep(_NOTES_FADE)
        write_bytes(picture, viewer.take_screenshot())


def _command(port: str) -> list[str]:
    return [viewer_binary(), "--bind", LOCAL, "--port", port, "--hide-welcome-screen"]
