"""A recording opened in the real viewer, without a screen: no view complains, and every view shows what it should."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlparse
from urllib.request import urlopen

import mujoco
import numpy as np
import pytest
from PIL import Image
from rerun.experimental import ViewerClient
from viewer_pages import count, pages, pixels_of, require_pages

from dr_lab.errors import DrLabError
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import Overlay
from dr_lab.recorders.rerun_process import viewer_binary
from dr_lab.recorders.review import write_review
from dr_lab.recorders.viewer import find_recording, open_viewer, screenshot, show
from dr_lab.recorders.web_viewer import served
from dr_lab.reports.gap import GapReport
from dr_lab.reports.markdown import report_markdown
from dr_lab.reports.plain import from_plain

_AT = 1.8  # s, where the model before is far from the measured robot


@pytest.fixture
def recording(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    close_report: dict[str, Any],
    overlay: Overlay,
    furuta: mujoco.MjModel,
    look: Look,
) -> Path:
    monkeypatch.setenv("RERUN_STRICT", "1")
    path = tmp_path / "review.rrd"
    report = from_plain(GapReport, close_report)
    write_review(path, report, report_markdown(report), [overlay], furuta, look)
    return path


@pytest.mark.viewer
def test_every_page_shows_what_it_says(viewer: ViewerClient, recording: Path, look: Look) -> None:
    show(viewer, recording, _AT)
    measured, before, after, noise = (look.colour(role) for role in ("measured", "before", "after", "noise"))
    command = look.colour("command")
    expected = {
        "Overview": {
            "measured (white), model before": [measured, before],
            "arm.position [rad]": [measured, before, after],
            "pole.position, measured": [before, after],
            "Ladder": [before, after],
        },
        "Signals": {"commands": [command], "after alone": [after], "pole.position [rad]": [measured, before, after]},
        "Residual and velocity": {
            "arm: position residual": [before, after],
            "pole: position residual": [before, after],
        },
        "Ranking": {"Ranking": [after, noise, measured]},
        "Report": {"Report": []},
    }
    require_pages(viewer, expected)


@pytest.mark.viewer
def test_the_simulated_robot_departs_before_and_not_after(viewer: ViewerClient, recording: Path, look: Look) -> None:
    show(viewer, recording, _AT)
    _, views = next(pages(viewer))
    apart = count(pixels_of(viewer, "measured (white), model before", views), look.colour("measured"))
    hidden = count(pixels_of(viewer, "measured (white), model after", views), look.colour("measured"))
    # After, the ghost lies upon the measured robot and tints it; what stays white is the title.
    assert apart > 2 * hidden


@pytest.mark.viewer
@pytest.mark.usefixtures("viewer")
def test_screenshot_is_a_picture_of_the_window(recording: Path) -> None:
    picture = recording.with_name("picture.png")
    screenshot(recording, picture, at=_AT, width=1200, height=700)
    with Image.open(picture) as image:
        assert image.size == (1200, 700)
        assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 500


def test_a_machine_without_a_display_is_told_of_the_browser(recording: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for variable in ("DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"):
        monkeypatch.delenv(variable, raising=False)
    with pytest.raises(DrLabError, match=r"(?s)DISPLAY.*in a browser instead: dr-lab view run=.*review\.rrd web=true"):
        open_viewer([recording])


@pytest.mark.viewer
def test_a_browser_finds_the_page_and_the_recording(viewer: ViewerClient, recording: Path) -> None:
    with served([recording]) as site, urlopen(site.url, timeout=10) as page:
        assert b"web viewer" in page.read()
        assert site.tunnel == f"-L {site.page}:127.0.0.1:{site.page} -L {site.data}:127.0.0.1:{site.data}"
        # What the page loads from its address, a viewer without a browser can load too.
        (source,) = parse_qs(urlparse(site.url).query)["url"]
        viewer.open(source)
        deadline = time.monotonic() + 30.0
        while not (views := viewer.get_state().views) and time.monotonic() < deadline:
            time.sleep(0.1)
        assert any(view.name.startswith("arm.position") for view in views)
    assert site.process.poll() is not None


def test_a_taken_port_gives_way(recording: Path) -> None:
    with served([recording]) as first, served([recording], first.page, first.data) as second:
        assert len({first.page, first.data, second.page, second.data}) == 4


def test_view_serves_until_ctrl_c(recording: Path) -> None:
    command = [sys.executable, "-m", "dr_lab", "view", f"run={recording}", "web=true", "page_port=0", "data_port=0"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=recording.parent)
    assert process.stdout is not None
    try:
        said = [process.stdout.readline() for _ in range(5)]
        assert "http://127.0.0.1:" in said[2]
        assert "ssh -L" in said[3]
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=10)[1] == ""
        assert process.returncode == 0
    finally:
        process.kill()  # one that goes on would keep a core busy


def test_missing_recordings_are_named(tmp_path: Path) -> None:
    with pytest.raises(DrLabError, match=r"There is no file .*a\.rrd"):
        open_viewer([tmp_path / "a.rrd"])
    with pytest.raises(DrLabError, match="Run dr-lab compare first"):
        find_recording("latest", tmp_path)
    with pytest.raises(DrLabError, match=r"no recording .*nowhere"):
        find_recording(str(tmp_path / "nowhere"), tmp_path)


def test_latest_is_the_newest_run(tmp_path: Path) -> None:
    for age, name in enumerate(["b", "a"]):
        (tmp_path / name).mkdir()
        path = tmp_path / name / "review.rrd"
        path.write_bytes(b"RRF2")
        modified = path.stat().st_mtime - 100 * age
        os.utime(path, (modified, modified))
    assert find_recording("latest", tmp_path) == tmp_path / "b" / "review.rrd"
    assert find_recording(str(tmp_path / "a"), tmp_path) == tmp_path / "a" / "review.rrd"


def test_the_viewer_is_the_binary_itself() -> None:
    with Path(viewer_binary()).open("rb") as binary:
        assert binary.read(2) != b"#!"
