"""Logs that the other verbs cannot cut into windows are not held out."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from played_logs import write_log
from test_coverage import RAIL, swing

from dr_lab.__main__ import main
from dr_lab.proposal.rooms import Rooms


@pytest.mark.parametrize(
    ("windows", "held", "expected"),
    [
        ({"a": 9, "b": 9, "c": 9}, ["c"], ("c",)),  # as it was
        ({"a": 9, "b": 9, "c": 0}, ["c"], ("b",)),  # the nearest of those with enough
        ({"a": 9, "b": 2, "c": 1}, ["c"], ("a",)),
        ({"a": 1, "b": 2, "c": 0}, ["c"], ("b",)),  # none has enough
        ({"a": 0, "b": 9, "c": 0}, ["c"], ("c",)),  # the only one with windows is fitted
        ({"a": 0, "b": 9, "c": 0}, ["b"], ("b",)),  # a doubt says so
        ({n: int(n in "abde") * 3 for n in "abcdef"}, ["c", "f"], ("b", "e")),
    ],
)
def test_a_log_with_too_few_windows_is_fitted(
    windows: dict[str, int], held: list[str], expected: tuple[str, ...]
) -> None:
    assert Rooms(windows, windows).held(held, list(windows), 3) == expected


def proposed(folder: Path, monkeypatch: pytest.MonkeyPatch, seconds: tuple[float, ...]) -> dict[str, Any]:
    """What init makes of logs of so many seconds of a mass that swings on a spring."""
    monkeypatch.chdir(folder)
    Path("it.xml").write_text(RAIL)
    rng, paths = np.random.default_rng(0), []
    for name, long in zip("abcdef", seconds, strict=False):
        signal = swing(name, 0.5).outputs["rail.position"]
        some = signal.time < long
        noise = rng.normal(scale=1e-4, size=len(signal.time))
        value = signal.value * np.exp(-0.05 * signal.time) + noise
        paths.append(write_log(name, "t,rail_m", signal.time[some], value[some]))
    assert main(["init", "it.xml", *paths]) == 0
    return yaml.safe_load(Path("mine/measurements/it.yaml").read_text(encoding="utf-8"))


def test_init_holds_out_a_log_with_windows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The third log is too short for a window of 0.44 s."""
    assert proposed(tmp_path, monkeypatch, (4.0, 4.0, 0.4))["held_out"] == ["b"]


def test_init_says_which_length_would_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Windows of 0.24 s take 0.38 s with what is simulated before and after them."""
    proposed(tmp_path, monkeypatch, (0.4, 0.4, 0.4))
    assert "holds a gapless window of 0.44 s, which the other verbs ask for. Give them windows.length=0.24, or" in (
        capsys.readouterr().out
    )
