from types import SimpleNamespace
from typing import Any, cast

import pytest
from diagnosis_machines import evidence_settings, pendulum, swinging, windows_of, windows_settings

from dr_lab.workflows.notes import few_blocks


@pytest.mark.parametrize(("windows", "told"), [(1, "1 block of data"), (2, "2 blocks of data"), (3, None)])
def test_too_few_held_out_windows_are_told(windows: int, told: str | None) -> None:
    model = pendulum()
    held_out = windows_of(model, [swinging("a", model.nominal(), 0)], windows_settings(seconds=0.3 * windows))
    notes = few_blocks(cast(Any, SimpleNamespace(held_out=held_out, evidence=evidence_settings())))
    assert [note["count"] for note in notes] == ([windows] if told else [])
    for note in notes:
        assert str(told) in note["message"]
        assert "evidence.least_compared" in note["message"]
