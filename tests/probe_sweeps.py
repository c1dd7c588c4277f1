"""Sweeps of the verb `probe`: cheap jobs in real processes, whose driver can be killed."""

import csv
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

import dr_lab.workflows
from dr_lab.__main__ import main
from dr_lab.cli import folders
from dr_lab.sweeps.job_folder import STATUS_FILE
from dr_lab.sweeps.table import TABLE_FILE

PROBE = Path(__file__).parent / "probe_verb"


class Sweeps:
    """Runs `dr-lab probe -m` in a folder of its own.

    Args:
        home: an empty folder.
    """

    def __init__(self, home: Path) -> None:
        self.home, self.trouble = home, home / "trouble"
        for group in ("base", "hydra"):
            shutil.copytree(folders.shipped() / group, home / "conf" / group)
        shutil.copy(PROBE / "probe.yaml", home / "conf")
        self.trouble.mkdir()
        self.stdout, self.stderr = home / "stdout.txt", home / "stderr.txt"

    def here(self, monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
        """Run a command in this process; gives its exit code."""
        monkeypatch.setattr(folders, "PACKAGE", self.home / "dr_lab")
        monkeypatch.setattr(dr_lab.workflows, "__path__", [*dr_lab.workflows.__path__, str(PROBE)])
        monkeypatch.setattr(sys, "argv", ["dr-lab"])
        monkeypatch.chdir(self.home)
        return main(["probe", "-m", *arguments])

    def start(self, *arguments: str, **variables: str) -> "subprocess.Popen[bytes]":
        """Begin a command, with environment variables; it writes to files, which workers may outlive."""
        path = os.pathsep.join([str(PROBE), os.environ.get("PYTHONPATH", "")])
        env = os.environ | {"PYTHONPATH": path, "PROBE_HOME": str(self.home), "PYTHONWARNINGS": "ignore", **variables}
        command = [sys.executable, "-m", "dr_lab", "probe", "-m", *arguments]
        with self.stdout.open("w") as out, self.stderr.open("w") as error:
            return subprocess.Popen(command, cwd=self.home, env=env, stdout=out, stderr=error)

    def run(self, *arguments: str, **variables: str) -> int:
        """Run a command to its end; gives its exit code."""
        return self.start(*arguments, **variables).wait(timeout=300)

    def told(self) -> str:
        """What the last command wrote to stderr."""
        return self.stderr.read_text(encoding="utf-8")


def table(folder: Path) -> list[dict[str, str]]:
    """The rows of a sweep's table, without how long things took."""
    with (folder / TABLE_FILE).open(encoding="utf-8") as file:
        return [{key: value for key, value in row.items() if key != "seconds"} for row in csv.DictReader(file)]


def completed(folder: Path) -> Mapping[str, tuple[int, str]]:
    """The jobs that are completed, each with what shows whether it was run again: file and content of its status."""
    found = {path: path.read_text(encoding="utf-8") for path in folder.glob(f"*/{STATUS_FILE}")}
    done = {path: text for path, text in found.items() if json.loads(text)["state"] == "completed"}
    return {path.parent.name: (path.stat().st_ino, text) for path, text in done.items()}
