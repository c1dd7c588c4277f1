"""The command line over a small configuration of its own."""

import shutil
import sys
from pathlib import Path

import pytest
from cli_machine import FILES, CommandLine, Effect, Machine, broken, module, write

from dr_lab.cli import folders


@pytest.fixture
def dr_lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> CommandLine:
    """The command line over a temporary configuration, standing in an empty working folder."""
    for group in ("base", "hydra"):
        shutil.copytree(folders.shipped() / group, tmp_path / "conf" / group)
    for name, text in FILES.items():
        write(tmp_path / "conf" / name, text)
    line = CommandLine()
    parts = {"Machine": Machine, "Effect": Effect, "broken": broken}
    for function in parts.values():
        monkeypatch.setattr(function, "__module__", "parts")
    monkeypatch.setitem(sys.modules, "parts", module("parts", **parts))
    for verb in ("compare", "add"):
        name = f"dr_lab.workflows.{verb}"
        monkeypatch.setitem(sys.modules, name, module(name, **{verb: getattr(line, verb)}))
    monkeypatch.setattr(folders, "PACKAGE", tmp_path / "dr_lab")
    monkeypatch.setenv("DR_LAB_TRUST", "parts")
    monkeypatch.setattr(sys, "argv", ["dr-lab"])
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    return line
