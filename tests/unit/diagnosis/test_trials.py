"""Effects on trial beside effects that are beyond doubt, on models of which only the scores are known."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from effect_machines import block, placed
from trial_machines import (
    BENCH,
    BLOCKS,
    NOTHING,
    RICH,
    SCATTERED,
    SETTINGS,
    SIMPLE,
    WIDE,
    Machine,
    candidate,
    climb,
    effects_of,
    fitted_model,
    labels,
    prepare,
)

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.evidence.paired_gain import paired_gain
from dr_lab.diagnosis.evidence.support import supported, worth_a_trial
from dr_lab.diagnosis.search import climb as climbing
from dr_lab.diagnosis.search import pruning
from dr_lab.diagnosis.search.climb_watch import Silence
from dr_lab.diagnosis.search.deletions import Deletions
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.diagnosis.search.rung import Rung
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.diagnosis.search.verdict import decide
from dr_lab.effects.catalogue import SpecialCases
from dr_lab.effects.effect import PlacedEffect
from dr_lab.trajectory import Array


def test_what_is_in_doubt_takes_no_place_of_what_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """Alone the richer effect leaves as little as both, but that it leaves less than the simple one is in doubt."""

    def left(effects: Sequence[PlacedEffect]) -> Array:
        return 1 - 0.8 * SCATTERED if RICH in effects else np.ones(BLOCKS) if effects else WIDE

    machine = Machine((SIMPLE, RICH), left)
    simple, rich = (machine.explain((effect,)).held_out for effect in (SIMPLE, RICH))
    doubtful = paired_gain(simple, rich, SETTINGS)
    assert worth_a_trial(doubtful, len(RICH.parameters), SETTINGS)
    assert not supported(doubtful, len(RICH.parameters), SETTINGS)
    climbed = climb(machine, monkeypatch)
    assert [rung.verdict.effects for rung in climbed.rungs] == [(SIMPLE.label,), (), ()]
    assert climbed.rungs[1].verdict.trial == (RICH.label,)
    assert [step.fitted_model.model.effects[-1].label for step in climbed.steps] == [SIMPLE.label]
    assert all(step.proven for step in climbed.steps)
    assert climbed.dropped == (RICH.label,)
    assert [rung.verdict.absorbed for rung in climbed.rungs] == [(), (RICH.label,), ()]
    assert climbed.absorbed == (RICH.label,)  # beside the model that is left


def test_the_climb_goes_on_from_what_a_trial_that_falls_leaves(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside the one on trial two others show, which make it superfluous; while it is there it hides a fourth."""
    doubtful, first, second, fourth = (
        placed(block(), name, "rail")
        for name in ("coulomb_friction", "viscous_friction", "quadratic_drag", "constant_offset")
    )

    def left(effects: Sequence[PlacedEffect]) -> Array:
        if {first, second} <= set(effects):
            return np.repeat(1.0 if fourth in effects and doubtful not in effects else 5.0, BLOCKS)
        if {doubtful, first} <= set(effects):
            return np.repeat(10.0, BLOCKS)
        return WIDE - 12.0 * SCATTERED if doubtful in effects else WIDE

    climbed = climb(Machine((doubtful, first, second, fourth), left), monkeypatch)
    assert [labels(effects_of(rung.base)) for rung in climbed.rungs] == [
        [],
        [doubtful.label],
        labels([doubtful, first]),
        labels([doubtful, first, second]),
        labels([first, second]),
        labels([first, second, fourth]),
    ]
    assert climbed.dropped == (doubtful.label,)
    assert labels(effects_of(climbed.models[-1])) == labels([first, second, fourth])
    assert all(step.proven for step in climbed.steps)


def test_what_is_in_doubt_falls_when_the_climb_is_over_not_before(monkeypatch: pytest.MonkeyPatch) -> None:
    first, second = (placed(block(), name, "rail") for name in ("coulomb_friction", "viscous_friction"))

    def left(effects: Sequence[PlacedEffect]) -> Array:
        if {first, second} <= set(effects):
            return 4.0 - 2.5 * SCATTERED
        return np.repeat(4.0, BLOCKS) if second in effects else np.repeat(16.0, BLOCKS) if first in effects else WIDE

    machine = Machine((first, second), left)
    prepare(machine, monkeypatch)
    alone, both = machine.explain((second,)).held_out, machine.explain((first, second)).held_out
    assert worth_a_trial(paired_gain(alone, both, SETTINGS), len(first.parameters), SETTINGS)
    assert not supported(paired_gain(alone, both, SETTINGS), len(first.parameters), SETTINGS)
    steps = tuple(AddedEffect(machine.explain(effects), ()) for effects in ((first,), (first, second)))
    cases = SpecialCases({}, NOTHING, NOTHING)
    assert pruning.lean(Deletions(BENCH), machine.explain(()), steps, cases).dropped == ()
    assert pruning.finished(Deletions(BENCH), machine.explain(()), steps, cases).dropped == (first.label,)


def test_a_ladder_that_stays_is_judged_in_the_end_without_fits_that_are_known(monkeypatch: pytest.MonkeyPatch) -> None:
    first, second, none = (
        placed(block(), name, "rail") for name in ("coulomb_friction", "viscous_friction", "quadratic_drag")
    )

    def left(effects: Sequence[PlacedEffect]) -> Array:
        return np.repeat(1.0 + 8.0 * (first not in effects) + 8.0 * (second not in effects), BLOCKS)

    machine, fitted = Machine((first, second, none), left), list[tuple[list[str], list[str]]]()

    def noted(_: Deletions, base: FittedModel, fewer: tuple[AddedEffect, ...], whole: FittedModel, __: float) -> object:
        fitted.append((labels(effects_of(whole)), [step.effect.label for step in fewer]))
        return fewer, base

    prepare(machine, monkeypatch)
    monkeypatch.setattr(Deletions, "_as_good_as_it_can", noted)
    begun = climbing.Climb.begun(BENCH, machine.explain(()))
    climbed = climbing.climb(begun, {}, NOTHING, NOTHING, most=4, watch=Silence())
    assert labels(effects_of(climbed.models[-1])) == labels([first, second])
    assert climbed.topped(climbed.models[-1]) is climbed
    both = [fewer for whole, fewer in fitted if whole == labels([first, second])]
    assert sorted(both) == [[first.label], [second.label]]


@pytest.mark.parametrize(("base", "verdict"), [(WIDE, "unexplained"), (np.repeat(0.09, BLOCKS), "none")])
def test_where_all_that_was_added_is_dropped_nothing_is_named(base: Array, verdict: str) -> None:
    below = fitted_model((), base)
    ranking = (candidate(below, fitted_model((SIMPLE,), np.zeros(BLOCKS))),)
    rung = Rung(below, ranking, decide(below, ranking, SETTINGS))
    whole = Ladder((rung,), below, ())
    assert whole.verdict(SETTINGS) == "named"  # `most` is 0: nothing was tried beside it
    assert replace(whole, dropped=(SIMPLE.label,)).verdict(SETTINGS) == verdict


OFFSET = placed(block(), "constant_offset", "rail")


def test_an_effect_compatible_with_its_absence_does_not_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    def left(effects: Sequence[PlacedEffect]) -> Array:
        return np.zeros(BLOCKS) if OFFSET in effects else WIDE

    name = OFFSET.parameters[0].name
    assert climb(Machine((OFFSET,), left, {name: (1.0, 0.35)}), monkeypatch).dropped == ()
    climbed = climb(Machine((OFFSET,), left, {name: (1.0, 0.5)}), monkeypatch)
    assert (climbed.steps, climbed.dropped) == ((), (OFFSET.label,))
    assert climbed.verdict(SETTINGS) == "unexplained"
