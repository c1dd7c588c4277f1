"""Richer kinds of an effect, weighed anew beside what was missing when they were first weighed."""

from collections.abc import Sequence

import numpy as np
import pytest
from effect_machines import block, placed
from trial_machines import BLOCKS, RICH, SIMPLE, Machine, climb, effects_of, labels

from dr_lab.effects.effect import PlacedEffect
from dr_lab.trajectory import Array

OTHER = placed(block(), "viscous_friction", "rail")


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
    machine, ranked = leaving(0.0), list[int]()
    alone = Machine((SIMPLE, RICH), lambda effects: machine.left((*effects, OTHER)))
    rank = alone.rank

    def noted(*asked: object) -> object:
        ranked.append(len(asked[2]))  # pyright: ignore[reportArgumentType]
        return rank(*asked)  # pyright: ignore[reportArgumentType]

    monkeypatch.setattr(alone, "rank", noted)
    climbed = climb(alone, monkeypatch)
    assert labels(effects_of(climbed.models[-1])) == [SIMPLE.label]
    assert ranked == [2, 0]
