"""A climb that ends with nothing tells what would explain much of the gap, but not beyond doubt."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from trial_machines import BLOCKS, SCATTERED, SETTINGS, SIMPLE, WIDE, Machine, climb

from dr_lab.comparison.in_doubt import in_doubt
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.effects.effect import PlacedEffect
from dr_lab.reports.gap_entries import IN_DOUBT
from dr_lab.trajectory import Array

HALF = -19.0 * SCATTERED  # closes much of a gap of 20 in some blocks, and widens it in the others


def machine(gain: Array) -> Machine:
    """One that leaves so much more or less by block with its only effect."""

    def left(effects: Sequence[PlacedEffect]) -> Array:
        return WIDE + gain if effects else WIDE

    return Machine((SIMPLE,), left)


@pytest.mark.parametrize("most", [4, 0])
def test_what_is_dropped_as_the_last_or_never_added_is_told_where_it_explains_much(
    monkeypatch: pytest.MonkeyPatch, most: int
) -> None:
    ladder = climb(machine(HALF), monkeypatch, most=most)
    assert ladder.steps == ()
    (note,) = in_doubt(ladder, SETTINGS)
    assert note.kind == IN_DOUBT
    assert note.message.startswith(f"**In doubt:** `{SIMPLE.label}` closes ")
    assert "64 % of a typical window's gap, χ² 20.99 → 14.34, but windows gain too unequally by it" in note.message
    assert "(share of a typical window's χ² that it removes: 61 %, 99 % interval from -27 %)" in note.message
    assert note.message.endswith("More logs would tell.")


@pytest.mark.parametrize("gain", [np.zeros(BLOCKS), -19.0 * np.ones(BLOCKS)])
def test_nothing_is_said_where_nothing_gains_or_where_all_is_clear(
    monkeypatch: pytest.MonkeyPatch, gain: Array
) -> None:
    assert in_doubt(climb(machine(gain), monkeypatch), SETTINGS) == []


def test_what_a_user_added_without_support_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    found = climb(machine(HALF), monkeypatch, most=0)
    best = found.rungs[0].ranking[0]
    added = replace(found, steps=(AddedEffect(best.fitted_model, (), proven=False),))
    (note,) = in_doubt(added, SETTINGS)
    assert note.message.startswith(f"**In doubt:** `{SIMPLE.label}` closes 64 % of a typical window's gap, χ² 20.99")
    assert in_doubt(replace(added, steps=(AddedEffect(best.fitted_model, ()),)), SETTINGS) == []
