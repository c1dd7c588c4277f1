"""The git state of a checkout, in a repository of its own."""

import subprocess
from pathlib import Path

import pytest

from dr_lab.cli import provenance


def git(folder: Path, *arguments: str) -> str:
    identity = ["-c", "user.name=a", "-c", "user.email=a@b"]
    command = ["git", "-C", str(folder), *identity, *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def test_commit_and_dirtiness(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(provenance, "PACKAGE", tmp_path / "dr_lab")
    assert provenance.git_state() is None
    git(tmp_path, "init", "--quiet")
    tracked = tmp_path / "tracked"
    tracked.write_text("1")
    git(tmp_path, "add", "tracked")
    git(tmp_path, "commit", "--quiet", "-m", "first")
    head = git(tmp_path, "rev-parse", "HEAD")
    (tmp_path / "untracked").write_text("")
    assert provenance.git_state() == {"commit": head, "dirty": False}
    tracked.write_text("2")
    assert provenance.git_state() == {"commit": head, "dirty": True}


def test_machine_without_git(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / ".git").mkdir()
    monkeypatch.setattr(provenance, "PACKAGE", tmp_path / "dr_lab")
    monkeypatch.setenv("PATH", "")
    assert provenance.git_state() is None
