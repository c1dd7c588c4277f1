import os
from pathlib import Path

import pytest

from dr_lab.errors import DrLabError
from dr_lab.files import atomic, remove_leftovers, write_bytes, write_text


def test_writes_and_replaces_whole_files(tmp_path: Path) -> None:
    path = tmp_path / "new" / "folder" / "a.txt"
    write_text(path, "χ² = 1\n")
    assert path.read_bytes() == "χ² = 1\n".encode()
    write_bytes(path, b"second")
    assert path.read_bytes() == b"second"
    assert os.listdir(path.parent) == ["a.txt"]


def _fail_halfway(path: Path, failure: type[BaseException]) -> None:
    with atomic(path) as temporary:
        temporary.write_bytes(b"half")
        raise failure


@pytest.mark.parametrize("failure", [ValueError, KeyboardInterrupt])
def test_failure_leaves_the_old_file_and_nothing_else(tmp_path: Path, failure: type[BaseException]) -> None:
    path = tmp_path / "a.bin"
    write_bytes(path, b"old")
    with pytest.raises(failure):
        _fail_halfway(path, failure)
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["a.bin"]


def test_temporary_file_lies_beside_and_keeps_the_suffix(tmp_path: Path) -> None:
    with atomic(tmp_path / "a.rrd") as temporary:
        assert temporary.parent == tmp_path
        assert temporary.suffix == ".rrd"
        assert not (tmp_path / "a.rrd").exists()


@pytest.mark.parametrize("name", ["a.rrd", "checkpoint", ".hidden"])
def test_what_a_killed_process_leaves_can_be_removed(tmp_path: Path, name: str) -> None:
    others = {name, ".lock", ".sweep.lock", "b.0123.txt"}
    for other in others:
        (tmp_path / other).touch()
    with atomic(tmp_path / name) as temporary:
        left = temporary.name
    (tmp_path / left).touch()
    remove_leftovers(tmp_path)
    assert set(os.listdir(tmp_path)) == others


def test_permissions_follow_the_umask(tmp_path: Path) -> None:
    (tmp_path / "plain").touch()
    write_text(tmp_path / "atomic", "x")
    assert (tmp_path / "atomic").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_unwritable_folder_names_the_file_and_the_remedy(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(DrLabError, match=r"Cannot write .*a\.txt.*Choose a folder.*sweep hydra\.sweep\.dir=FOLDER"):
        write_text(tmp_path / "file" / "a.txt", "x")


def test_a_folder_in_the_way_is_an_error_of_the_user(tmp_path: Path) -> None:
    (tmp_path / "taken").mkdir()
    with pytest.raises(DrLabError, match="Cannot write"):
        write_text(tmp_path / "taken", "x")
    assert os.listdir(tmp_path) == ["taken"]
