"""Shifts in time that would explain much and are too short to be named."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from diagnosis_machines import evidence_settings
from pretended_rankings import CLEAR, candidate, model

from dr_lab.comparison.short_shifts import short_shifts
from dr_lab.diagnosis.evidence.bench import Bench
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.diagnosis.search.rung import Rung
from dr_lab.diagnosis.search.verdict import decide
from dr_lab.reports.gap_entries import SHORT_SHIFT

STEP = 0.002  # s


def bench() -> Bench:
    return cast(Bench, SimpleNamespace(evidence=evidence_settings(), timing_resolution=STEP))


def shift(level: float, left: float, *, resolved: bool = False) -> Candidate:
    """A delay of 1.135 ms that brings a χ² down to another."""
    found = candidate(model(level), "actuator_delay", left, CLEAR)
    effect, fit = found.effect, SimpleNamespace(z=np.array([0.001135]))
    space = SimpleNamespace(mapping=lambda z: {effect.parameters[0].name: float(z[0])})
    fitted = replace(found.fitted_model, model=cast(Any, SimpleNamespace(space=space)), fit=cast(Any, fit))
    return replace(found, fitted_model=fitted, resolved=resolved)


def told(level: float, *ranking: Candidate) -> list[str]:
    base = model(level)
    verdict = decide(base, [], evidence_settings())
    rung = Rung(base, ranking, verdict)
    notes = short_shifts(bench(), Ladder((rung,), base, ()))
    assert {note.kind for note in notes} <= {SHORT_SHIFT}
    return [note.message for note in notes]


def test_a_shift_below_the_step_that_explains_much_is_told_with_the_remedy() -> None:
    (message,) = told(4.0, shift(4.0, 3.0), shift(4.0, 1.0))
    assert message.startswith("`actuator_delay@drive` (1.14 ms) would leave χ² 0.99")
    assert "a shift of less than 2 ms may be that of the time step" in message
    assert "finer timestep" in message


@pytest.mark.parametrize(
    ("level", "found"),
    [
        pytest.param(4.0, shift(4.0, 1.0, resolved=True), id="it can be named"),
        pytest.param(4.0, shift(4.0, 3.98), id="it explains a trifle"),
        pytest.param(1.0, shift(1.0, 0.9), id="only noise is left"),
    ],
)
def test_otherwise_there_is_nothing_to_say(level: float, found: Candidate) -> None:
    assert told(level, found) == []
