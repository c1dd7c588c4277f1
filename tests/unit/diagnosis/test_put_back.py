"""Richer effects in whose place a special case of them stands, on models of which only the scores are known."""

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from effect_machines import block, placed
from trial_machines import (
    BENCH,
    BLOCKS,
    NOTHING,
    RICH,
    SETTINGS,
    SIMPLE,
    WIDE,
    WINDOWS,
    Machine,
    candidate,
    climb,
    effects_of,
    labels,
    prepare,
    score,
)

from dr_lab.comparison.notes import put_back
from dr_lab.diagnosis.evidence.bench import Bench, FittedModel
from dr_lab.diagnosis.evidence.paired_gain import paired_gain
from dr_lab.diagnosis.evidence.score import ChannelScore
from dr_lab.diagnosis.search import pruning
from dr_lab.diagnosis.search.deletions import Deletions
from dr_lab.diagnosis.search.put_back import PutBack, closes_little
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.effects.catalogue import SpecialCases
from dr_lab.effects.effect import PlacedEffect
from dr_lab.trajectory import Array

SKEW, TILT, SOFT = (placed(block(), name, "rail") for name in ("asymmetric_friction", "constant_offset", "armature"))
SLIDING = placed(block(), "presliding_friction", "rail")
CREEP = next(p for p in SLIDING.parameters if p.name.endswith("creep"))
ASYMMETRY = f"{SKEW.label}.asymmetry"


def beside_a_tilt(effects: Sequence[PlacedEffect]) -> Array:
    """The tilt's absence lets the asymmetry explain a lot; beside the tilt it explains nothing."""
    rubs, tilted = SKEW in effects or SIMPLE in effects, TILT in effects
    if rubs and tilted:
        return np.zeros(BLOCKS)
    return np.repeat(2.0 if SKEW in effects else 10.0 if rubs else 15.0 if tilted else 20.0, BLOCKS)


@pytest.mark.parametrize(("value", "std"), [(0.0004, 0.0054), (0.2, 0.01)])
def test_what_explains_no_more_beside_what_was_missing_is_put_back(
    value: float, std: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    machine = Machine((SIMPLE, SKEW, TILT), beside_a_tilt, {ASYMMETRY: (value, std)})
    climbed = climb(machine, monkeypatch)
    assert climbed.rungs[0].verdict.effects == (SKEW.label,)
    assert labels(effects_of(climbed.models[-1])) == labels([SIMPLE, TILT])
    assert labels(effects_of(climbed.models[1])) == [SIMPLE.label]
    assert climbed.dropped == ()
    (back,) = climbed.put_back
    assert (back.richer, back.poorer, back.further) == (SKEW.label, SIMPLE.label, {"asymmetry": (value, std)})
    assert back.compatible == (value < std)


@pytest.mark.parametrize(("left", "stay"), [(0.0, (SIMPLE, TILT)), (2.0, (SKEW, SOFT))])
def test_two_effects_that_share_what_another_does_alone_give_way_to_it(
    left: float, stay: tuple[PlacedEffect, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beside what was added second the asymmetry explains a lot, beside its rival, which explains as much, nothing."""

    def leaves(effects: Sequence[PlacedEffect]) -> Array:
        known = [([SKEW, SOFT], 0.0), ([SKEW, TILT], 0.0), ([SIMPLE, TILT], left)]
        alike = [excess for pair, excess in known if labels(effects) == labels(pair)]
        return np.repeat(alike[0] if alike else 20.0 - 5.0 * len(effects), BLOCKS)

    machine = Machine((SIMPLE, SKEW, SOFT, TILT), leaves, {ASYMMETRY: (0.2, 0.01)})
    prepare(machine, monkeypatch)
    first, second = machine.explain((SKEW,)), machine.explain((SKEW, SOFT))
    rival = candidate(first, machine.explain((SKEW, TILT)))
    steps, cases = (AddedEffect(first, ()), AddedEffect(second, (rival,))), SpecialCases({}, NOTHING, NOTHING)
    found, back = pruning.plainer(Deletions(BENCH), machine.explain(()), steps, cases)
    assert labels(effects_of(found[-1].fitted_model)) == labels(stay)
    assert [each.richer for each in back] == ([SKEW.label] if SKEW not in stay else [])


@pytest.mark.parametrize(
    ("std", "leaves", "stays"),
    [
        (0.01, 1.0, SKEW),
        (0.1, 1.0, SIMPLE),
        (0.1, 0.0, SKEW),  # noise: no wrong model, whose errors would scatter
    ],
)
def test_a_richer_effect_stands_if_the_scatter_between_logs_lets_it_or_noise_is_left(
    std: float, leaves: float, stays: PlacedEffect, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It explains more of the held-out logs; alone it is judged when the climb is over."""

    def left(effects: Sequence[PlacedEffect]) -> Array:
        return np.repeat(leaves if SKEW in effects else 3.0 if SIMPLE in effects else 20.0, BLOCKS)

    climbed = climb(Machine((SIMPLE, SKEW), left, {ASYMMETRY: (0.2, std)}), monkeypatch)
    assert labels(effects_of(climbed.models[-1])) == [stays.label]
    assert [back.compatible for back in climbed.put_back] == ([True] if stays is SIMPLE else [])


def test_a_richer_effect_that_changes_no_more_than_the_time_step_is_put_back(monkeypatch: pytest.MonkeyPatch) -> None:
    def left(effects: Sequence[PlacedEffect]) -> Array:
        return np.repeat(1.0 if SKEW in effects else 3.0 if SIMPLE in effects else 20.0, BLOCKS)

    machine = Machine((SIMPLE, SKEW), left, {ASYMMETRY: (0.2, 0.01)})
    prepare(machine, monkeypatch)
    steps, cases = (AddedEffect(machine.explain((SKEW,)), ()),), SpecialCases({}, NOTHING, NOTHING)
    assert pruning.simplify(Deletions(BENCH), machine.explain(()), steps, cases) is None
    monkeypatch.setattr(pruning, "hidden_by_step", lambda *_: True)
    found = pruning.simplify(Deletions(BENCH), machine.explain(()), steps, cases)
    assert found is not None
    assert [step.effect.label for step in found[0]] == [SIMPLE.label]
    assert found[1].hidden


@pytest.mark.parametrize(
    ("richer", "poorer", "stays"),
    [
        (0.08, 0.12, SIMPLE),  # a third of a gap that hardly shows: so much may be another simulator's time step
        (0.02, 0.12, SKEW),
        (0.25, 0.4, SKEW),  # less than half, of a gap that shows: a better model, with more to come
    ],
)
def test_a_richer_effect_closes_half_of_a_gap_that_hardly_shows(
    richer: float, poorer: float, stays: PlacedEffect, monkeypatch: pytest.MonkeyPatch
) -> None:
    def left(effects: Sequence[PlacedEffect]) -> Array:
        return np.repeat(richer if SKEW in effects else poorer if SIMPLE in effects else 20.0, BLOCKS)

    climbed = climb(Machine((SIMPLE, SKEW), left, {ASYMMETRY: (0.2, 0.01)}), monkeypatch)
    assert labels(effects_of(climbed.models[-1])) == [stays.label]
    assert [back.little for back in climbed.put_back] == ([True] if stays is SIMPLE else [])


def test_what_instruments_make_is_no_gap_of_which_a_richer_effect_closes_little() -> None:
    """χ² 1.09 to 1.06: a third of the gap above white noise, and all of it where the rest is the instruments' own."""
    counts = np.full(WINDOWS, 300.0)

    def fitted(chi2: float, *, instrumental: bool) -> FittedModel:
        channel = ChannelScore(chi2 * counts, counts, 1.0, instrumental)
        held_out = replace(score(np.full(BLOCKS, chi2 - 1)), channels={"position": channel})
        return cast(FittedModel, SimpleNamespace(held_out=held_out))

    poorer = fitted(1.09, instrumental=True)
    assert closes_little(poorer, fitted(1.06, instrumental=False), SETTINGS)
    assert not closes_little(poorer, fitted(1.06, instrumental=True), SETTINGS)


@pytest.mark.parametrize(("creep", "stays"), [(CREEP.low, SIMPLE), (CREEP.high, SLIDING)])
def test_a_richer_effect_that_ended_where_it_is_its_special_case_is_put_back(
    creep: float, stays: PlacedEffect, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever it gains there is by how it is computed; a way and a damping that are nothing say as little."""
    known = {p.name: (p.low, 1.0) for p in SLIDING.parameters} | {CREEP.name: (creep, 0.01 * CREEP.high)}

    def left(effects: Sequence[PlacedEffect]) -> Array:
        return np.repeat(0.0 if SLIDING in effects else 3.0 if SIMPLE in effects else 20.0, BLOCKS)

    climbed = climb(Machine((SIMPLE, SLIDING), left, known), monkeypatch)
    assert labels(effects_of(climbed.models[-1])) == [stays.label]
    assert [back.at_limit for back in climbed.put_back] == ([True] if stays is SIMPLE else [])


@pytest.mark.parametrize(("left", "taken"), [(0.02, True), (3.0, False)])
def test_what_became_its_special_case_takes_the_fit_that_was_ranked_where_that_leaves_noise(
    left: float, monkeypatch: pytest.MonkeyPatch, *, taken: bool
) -> None:
    known = {p.name: (p.low, 1.0) for p in SLIDING.parameters} | {CREEP.name: (CREEP.low, 0.01 * CREEP.high)}

    def leaves(effects: Sequence[PlacedEffect]) -> Array:
        return np.repeat(0.0 if SLIDING in effects else left if SIMPLE in effects else 20.0, BLOCKS)

    machine = Machine((SIMPLE, SLIDING), leaves, known)
    prepare(machine, monkeypatch)
    base, deletions = machine.explain(()), Deletions(BENCH)
    ranked = candidate(base, machine.explain((SIMPLE,)))
    deletions.ranked([ranked])
    steps = (AddedEffect(machine.explain((SLIDING,)), ()),)
    found = pruning.simplify(deletions, base, steps, SpecialCases({}, NOTHING, NOTHING))
    assert found is not None
    assert (found[0][0].fitted_model is ranked.fitted_model) is taken
    assert labels(effects_of(found[0][0].fitted_model)) == [SIMPLE.label]


class Uneven(Machine):
    """A machine whose five held-out logs ask for the richer effect unequally; in the last window it does harm."""

    def explain(self, effects: tuple[PlacedEffect, ...]) -> FittedModel:
        found = super().explain(effects)
        return replace(found, held_out=replace(found.held_out, log=np.repeat(np.arange(5), WINDOWS // 5)))


@pytest.mark.parametrize(
    ("logs", "std", "stays"),
    [
        pytest.param(20, 0.02, True, id="ten standard deviations between twenty logs"),
        pytest.param(20, 0.1, False, id="two standard deviations"),
        pytest.param(2, 0.02, False, id="ten standard deviations between two logs"),
    ],
)
def test_logs_that_gain_unequally_are_held_against_an_effect_whose_parameters_are_badly_known(
    logs: int, std: float, stays: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def left(effects: Sequence[PlacedEffect]) -> Array:
        if SKEW in effects:
            return 0.3 + np.append(np.zeros(BLOCKS - 1), 0.01)
        unequal = 0.3 + 0.65 * np.array([1.9, 1.8, 0.1, 0.0, 1.2, 1.1, 2.7, 2.6, 0.4, 0.0])
        return unequal if SIMPLE in effects else WIDE

    machine = Uneven((SIMPLE, SKEW), left, {ASYMMETRY: (0.2, std)})
    prepare(machine, monkeypatch)
    steps = (AddedEffect(machine.explain((SKEW,)), ()),)
    gain = paired_gain(machine.explain((SIMPLE,)).held_out, steps[0].fitted_model.held_out, SETTINGS)
    assert gain.total_low < 0 < gain.blocks_low
    bench = cast(Bench, SimpleNamespace(**vars(BENCH) | {"fit": SimpleNamespace(log=np.arange(logs))}))
    found = pruning.simplify(Deletions(bench), machine.explain(()), steps, SpecialCases({}, NOTHING, NOTHING))
    assert (found is None) == stays


def test_what_was_needed_beside_the_richer_effect_alone_falls_with_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """The armature makes up for what the richer effect does wrong beside a tilt; the poorer one does it right."""

    def left(effects: Sequence[PlacedEffect]) -> Array:
        if SKEW in effects and TILT in effects and SOFT not in effects:
            return np.repeat(6.0, BLOCKS)
        return beside_a_tilt(effects)

    machine = Machine((SIMPLE, SKEW, SOFT, TILT), left, {ASYMMETRY: (0.0, 0.1)})
    prepare(machine, monkeypatch)
    steps = tuple(AddedEffect(machine.explain((SKEW, SOFT, TILT)[:k]), ()) for k in (1, 2, 3))
    found = pruning.lean(Deletions(BENCH), machine.explain(()), steps, SpecialCases({}, NOTHING, NOTHING))
    assert [step.effect.label for step in found.steps] == labels([SIMPLE, TILT])
    assert found.dropped == (SOFT.label,)
    assert [back.richer for back in found.put_back] == [SKEW.label]


def test_rivals_that_are_richer_kinds_of_what_is_put_back_are_none_any_more(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine((SIMPLE, SKEW), beside_a_tilt, {ASYMMETRY: (0.0, 0.1)})
    prepare(machine, monkeypatch)
    base = machine.explain(())
    rivals = tuple(candidate(base, machine.explain((each,))) for each in (SIMPLE, RICH, SOFT))
    steps = (AddedEffect(machine.explain((SKEW,)), rivals), AddedEffect(machine.explain((SKEW, TILT)), ()))
    found = pruning.lean(Deletions(BENCH), base, steps, SpecialCases({}, NOTHING, NOTHING))
    assert [rival.effect.label for rival in found.steps[0].rivals] == [SOFT.label]


def test_a_report_tells_what_was_put_back_and_why() -> None:
    found = PutBack(SKEW.label, SIMPLE.label, {"asymmetry": (0.0004, 0.0054)}, compatible=True, certain=False)
    unasked = replace(found, compatible=False)
    notes = put_back(
        [found, unasked, replace(unasked, hidden=True), replace(unasked, little=True), replace(found, at_limit=True)]
    )
    told, other, coarse, little, limit = (note.message for note in notes)
    assert told == (
        "asymmetric_friction@rail was put back to coulomb_friction@rail: its further parameters are compatible with "
        "nothing (asymmetry 0.0004 ± 0.0054)."
    )
    assert "explain no more" in other
    assert "change little beside what the time step does" in coarse
    assert "ended next to zero, where it is that" in limit
    assert "close a small part of the little that it leaves beyond the noise" in little
