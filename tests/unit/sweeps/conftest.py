"""Sweeps of cheap jobs, in this process."""

from collections.abc import Callable
from pathlib import Path

import pytest
from probe_sweeps import Sweeps


@pytest.fixture
def sweeps(tmp_path: Path) -> Sweeps:
    """Commands in an empty folder."""
    return Sweeps(tmp_path)


@pytest.fixture
def sweep(sweeps: Sweeps, monkeypatch: pytest.MonkeyPatch) -> Callable[..., int]:
    """`dr-lab probe -m … hydra.sweep.dir=swept`, in this process; gives the exit code."""

    def run(*arguments: str) -> int:
        return sweeps.here(monkeypatch, "hydra.sweep.dir=swept", *arguments)

    return run
