"""What the viewer is given: files that are recordings, ports that are free."""

import socket
from pathlib import Path

import pytest

from dr_lab.errors import ConfigError, DrLabError
from dr_lab.recorders.rerun_process import LOCAL, free_port
from dr_lab.recorders.viewer import find_recording, screenshot


def test_a_file_that_is_no_recording_is_refused_before_the_viewer_shows_nothing(tmp_path: Path) -> None:
    recording = tmp_path / "review.rrd"
    recording.write_bytes(b"RRF2\0")
    assert find_recording(str(recording), tmp_path) == recording
    for content in (b"", b"hi"):
        recording.write_bytes(content)
        with pytest.raises(DrLabError, match=r"review\.rrd is no recording: it does not begin as one"):
            find_recording(str(tmp_path), tmp_path)


def test_a_folder_at_home_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Hydra has the run quoted, which keeps the shell from putting the home in its place."""
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "review.rrd").write_bytes(b"RRF2\0")
    assert find_recording("~/run", tmp_path) == tmp_path / "run" / "review.rrd"


def test_a_report_is_refused_on_a_screen_as_in_a_browser(tmp_path: Path) -> None:
    report = tmp_path / "report.json"
    report.write_text("{}", "utf-8")
    with pytest.raises(DrLabError, match=r"report\.json is no recording, and the viewer opens no \.json file"):
        find_recording(str(report), tmp_path)
    page = tmp_path / "report.md"
    page.write_text("# page", "utf-8")
    assert find_recording(str(page), tmp_path) == page


@pytest.mark.parametrize("wanted", [99999, -1])
def test_a_port_that_does_not_exist_is_one_clear_error(wanted: int) -> None:
    with pytest.raises(ConfigError, match=rf"no port {wanted}; give page_port and data_port up to 65535"):
        free_port(wanted)


def test_a_taken_port_is_replaced() -> None:
    with socket.socket() as taken:
        taken.bind((LOCAL, 0))
        taken.listen()
        wanted = taken.getsockname()[1]
        assert free_port(wanted) not in (0, wanted)


def test_no_picture_of_a_recording_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(DrLabError, match=r"There is no file .*lost\.rrd to show\."):
        screenshot(tmp_path / "lost.rrd", tmp_path / "picture.png")
    assert list(tmp_path.iterdir()) == []
