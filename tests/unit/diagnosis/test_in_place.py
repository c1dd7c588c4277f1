"""Effects weighed anew in their place: beside what was missing at first, and against what they may be confused with."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from effect_machines import block, hanging, placed
from trial_machines import BENCH, BLOCKS, RICH, SCATTERED, SETTINGS, SIMPLE, Machine, climb, effects_of, labels, prepare

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel
from dr_lab.diagnosis.search.climb_watch import Silence
from dr_lab.diagnosis.search.deletions import Deletions
from dr_lab.diagnosis.search.in_place import weighed_anew
from dr_lab.diagnosis.search.rank import Ranking
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.effects.effect import PlacedEffect
from dr_lab.trajectory import Array

OTHER = placed(block(), "viscous_friction", "rail")


def noting(machine: Machine) -> list[list[str]]:
    """What is ranked when a machine's ladder is climbed, ranking by ranking."""
    ranked, rank = list[list[str]](), machine.rank

    def noted(_: Bench, base: FittedModel, placed: Sequence[PlacedEffect], __: object) -> Ranking:
        ranked.append(labels(placed))
        return rank(_, base, placed, __)

    machine.rank = noted
    return ranked


def leaving(simple: float) -> Machine:
    """A machine of which a friction law explains most; the simple one leaves so much beside what else is missing."""

    def left(effects: Sequence[PlacedEffect]) -> Array:
        rubbed, other = SIMPLE in effects or RICH in effects, OTHER in effects
        rest = simple if other and rubbed and RICH not in effects else 0.0
        return np.repeat(20.0 * (not rubbed) + 2.0 * (not other) + rest, BLOCKS)

    return Machine((SIMPLE, RICH, OTHER), left)


def test_a_richer_kind_that_only_shows_beside_what_was_missing_takes_the_place(monkeypatch: pytest.MonkeyPatch) -> None:
    climbed = climb(leaving(0.05), monkeypatch)
    assert climbed.rungs[0].verdict.effects == (SIMPLE.label,)
    assert labels(effects_of(climbed.models[-1])) == labels([OTHER, RICH])
    assert climbed.put_back == ()


def test_a_richer_kind_that_adds_nothing_there_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    climbed = climb(leaving(0.0), monkeypatch)
    assert labels(effects_of(climbed.models[-1])) == labels([SIMPLE, OTHER])


def test_what_was_weighed_beside_the_same_effects_is_not_weighed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside nothing else both friction laws were ranked, and the climb ends there."""
    machine = leaving(0.0)
    alone = Machine((SIMPLE, RICH), lambda effects: machine.left((*effects, OTHER)))
    ranked = noting(alone)
    climbed = climb(alone, monkeypatch)
    assert labels(effects_of(climbed.models[-1])) == [SIMPLE.label]
    assert ranked == [labels([SIMPLE, RICH]), []]


@pytest.mark.parametrize(("left_beside", "kept"), [(3.0, "flexible_mode"), (0.0, "coulomb_friction")])
def test_what_was_as_good_with_more_parameters_takes_the_place_if_it_explains_more_beside_what_was_missing(
    left_beside: float, kept: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The noise floor is out of reach: something else is missing that nothing explains."""
    richer = placed(block(), "flexible_mode", "rail")

    def left(effects: Sequence[PlacedEffect]) -> Array:
        some, other = SIMPLE in effects or richer in effects, OTHER in effects
        rest = left_beside if other and richer not in effects else 0.0
        return np.repeat(1.0 + 20.0 * (not some) + 8.0 * (not other) + rest, BLOCKS)

    climbed = climb(Machine((SIMPLE, richer, OTHER), left), monkeypatch, most=2)
    assert climbed.rungs[0].verdict.effects == (SIMPLE.label,)
    assert climbed.rungs[0].verdict.status[richer.label] == "not_needed"
    assert {effect.effect.name for effect in effects_of(climbed.models[-1])} == {kept, "viscous_friction"}


THERE = placed(hanging(), "coulomb_friction", "hinge")  # the same effect at another site
CONFUSED = placed(hanging(), "viscous_friction", "hinge")


def rubbing_twice(there: tuple[PlacedEffect, ...]) -> tuple[Machine, list[list[str]]]:
    """A machine with dry friction here, and with what these effects explain alike elsewhere; and what is ranked."""

    def left(effects: Sequence[PlacedEffect]) -> Array:
        return np.repeat(20.0 * (SIMPLE not in effects) + 2.0 * (not set(there) & set(effects)), BLOCKS)

    machine = Machine((SIMPLE, THERE, CONFUSED), left)
    return machine, noting(machine)


def test_what_is_named_is_asked_at_other_sites_before_all_else(monkeypatch: pytest.MonkeyPatch) -> None:
    machine, ranked = rubbing_twice((THERE,))
    climbed = climb(machine, monkeypatch)
    assert labels(effects_of(climbed.models[-1])) == labels([SIMPLE, THERE])
    every, same, rest, anew = ranked
    assert (every, same, rest) == (labels([SIMPLE, THERE, CONFUSED]), [THERE.label], [CONFUSED.label])
    assert anew == labels([THERE, CONFUSED])
    assert [step.rivals for step in climbed.steps] == [(), ()]
    assert not any(step.alike for step in climbed.steps)


def test_what_may_be_confused_with_it_there_is_a_rival_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    machine, _ = rubbing_twice((THERE, CONFUSED))
    climbed = climb(machine, monkeypatch)
    assert climbed.verdict(SETTINGS) == "equivalent"
    assert {c.effect.label for c in climbed.steps[1].rivals} | {climbed.steps[1].effect.label} == {
        THERE.label,
        CONFUSED.label,
    }


def test_where_nothing_else_has_it_the_whole_catalogue_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    machine, ranked = rubbing_twice((CONFUSED,))
    climbed = climb(machine, monkeypatch)
    assert labels(effects_of(climbed.models[-1])) == labels([SIMPLE, CONFUSED])
    assert ranked[1:3] == [[THERE.label], labels([THERE, CONFUSED])]


@pytest.mark.parametrize(("there", "added"), [(THERE, [SIMPLE, THERE]), (CONFUSED, [SIMPLE])])
def test_an_effect_at_several_sites_counts_once(
    there: PlacedEffect, added: list[PlacedEffect], monkeypatch: pytest.MonkeyPatch
) -> None:
    machine, _ = rubbing_twice((there,))
    climbed = climb(machine, monkeypatch, most=1)
    assert labels(effects_of(climbed.models[-1])) == labels(added)


def test_at_a_third_site_it_is_asked_on_trial(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a fourth site misses scatters what the third one gains; the whole catalogue waits until both are in."""
    (torque,) = THERE.parameters
    third, fourth = (
        replace(THERE, site=site, parameters=(replace(torque, name=f"coulomb_friction@{site}.torque"),))
        for site in ("third", "fourth")
    )

    def left(effects: Sequence[PlacedEffect]) -> Array:
        missing = 20.0 * (SIMPLE not in effects) + 8.0 * (THERE not in effects)
        if third in effects and fourth in effects:
            return np.repeat(missing, BLOCKS)
        alone = third in effects or fourth in effects
        return missing + (2.0 - 1.5 * SCATTERED if alone else np.repeat(2.0, BLOCKS))

    machine = Machine((SIMPLE, THERE, third, fourth, CONFUSED), left)
    ranked = noting(machine)
    climbed = climb(machine, monkeypatch)
    assert labels(effects_of(climbed.models[-1])) == labels([SIMPLE, THERE, third, fourth])
    assert [len(each) for each in ranked[:5]] == [5, 3, 2, 1, 1]
    assert [bool(rung.verdict.trial) for rung in climbed.rungs[:4]] == [False, False, True, False]


def test_an_effect_that_stands_keeps_its_place_and_is_no_rival_of_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two that the logs cannot separate the other one leaves a trifle less now."""

    def left(effects: Sequence[PlacedEffect]) -> Array:
        return np.repeat(0.0 if CONFUSED in effects else 0.001 if THERE in effects else 20.0, BLOCKS)

    machine = Machine((THERE, CONFUSED), left)
    prepare(machine, monkeypatch)
    steps = (AddedEffect(machine.explain((THERE,)), (), alike=True),)
    (found,) = weighed_anew(Deletions(BENCH), machine.explain(()), steps, [CONFUSED], (), Silence())
    assert found.effect.label == THERE.label
    assert [rival.effect.label for rival in found.rivals] == [CONFUSED.label]
