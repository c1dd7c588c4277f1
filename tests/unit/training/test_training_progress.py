"""Without a terminal, long work says now and then how far it has come."""

import pytest

from dr_lab.training import progress as module
from dr_lab.training.progress import progress


def test_a_line_says_what_is_left_at_the_pace_so_far(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter([0.0, 10.0, 40.0, 50.0, 400.0])
    monkeypatch.setattr(module.time, "monotonic", lambda: next(clock))
    with progress(1000.0, done=200.0) as show:
        for completed in (250.0, 400.0, 500.0, 600.0):
            show(completed, "Training, return 3.0")
    assert capsys.readouterr().out.splitlines() == [
        "Training, return 3.0: 40%, 2 min left",  # 200 took 40 s, 600 are left
        "Training, return 3.0: 60%, 7 min left",
    ]


def test_short_work_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with progress(1.0) as show:
        show(0.5, "Evaluating")
        show(1.0, "Evaluating")
    assert capsys.readouterr().out == ""
