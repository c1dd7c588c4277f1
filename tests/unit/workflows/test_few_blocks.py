from types import SimpleNamespace
from typing import Any, cast

import pytest
from diagnosis_machines import evidence_settings, pendulum, swinging, windows_of, windows_settings

from dr_lab.comparison.notes import few_blocks
from dr_lab.diagnosis.windows.windows import Windows


@pytest.mark.parametrize(
    ("windows", "fitted", "told"),
    [(1, 0, "1 block of data"), (2, 0, "2 blocks of data"), (3, 0, None), (1, 1, "2 blocks of data"), (1, 2, None)],
)
def test_too_few_windows_are_told(windows: int, fitted: int, told: str | None) -> None:
    held_out, fit = of(windows), of(max(fitted, 1))
    bench = SimpleNamespace(held_out=held_out, fit=fit, apart=fitted > 0, evidence=evidence_settings())
    notes = few_blocks(cast(Any, bench))
    assert [note.count for note in notes] == ([windows + fitted] if told else [])
    for note in notes:
        assert str(told) in note.message
        assert "evidence.least_compared" in note.message


def of(count: int) -> Windows:
    """So many windows of one log."""
    model = pendulum()
    return windows_of(model, [swinging("a", model.nominal(), 0)], windows_settings(seconds=0.3 * count))
