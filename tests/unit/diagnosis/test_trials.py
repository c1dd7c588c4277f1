"""Effects on trial beside effects that are beyond doubt, on models of which only the scores are known."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from diagnosis_machines import evidence_settings
from effect_machines import block, placed

from dr_lab.diagnosis import ladder
from dr_lab.diagnosis.bench import Bench, Explained
from dr_lab.diagnosis.evidence import paired_gain, supported, worth_a_trial
from dr_lab.diagnosis.identifiability import Identifiability
from dr_lab.diagnosis.ladder import Ladder, Rung
from dr_lab.diagnosis.rank import Candidate, Ranking
from dr_lab.diagnosis.score import Score
from dr_lab.diagnosis.verdict import decide
from dr_lab.effects.effect import PlacedEffect
from dr_lab.trajectory import Array

SETTINGS = evidence_settings()
BLOCKS, WINDOWS, COUNT = 10, 30, 300.0  # three windows a block, one log
NOISE = np.random.default_rng(0).chisquare(COUNT, WINDOWS)
SIMPLE, RICH = (placed(block(), name, "rail") for name in ("coulomb_friction", "stribeck_friction"))
BENCH = cast(Bench, SimpleNamespace(evidence=SETTINGS, scored="held-out logs"))
WIDE = np.repeat(20.0, BLOCKS)
SCATTERED = np.array([1.0, 1.0, -0.3, 1.0, -0.3, 1.0, -0.3, -0.3, 1.0, -0.3])


def score(excess: Array) -> Score:
    """χ² per sample beyond the noise's, by block."""
    sums = NOISE + COUNT * np.repeat(excess, WINDOWS // BLOCKS)
    counts = np.full(WINDOWS, COUNT)
    return Score(float(sums.sum() / counts.sum()), {}, {}, {}, sums, counts, np.zeros(WINDOWS, np.intp), 0)


def explained(effects: Sequence[PlacedEffect], excess: Array) -> Explained:
    model, fit = SimpleNamespace(effects=tuple(effects)), SimpleNamespace(below=lambda _: 0.0)
    return Explained(cast(Any, model), cast(Any, fit), cast(Any, None), score(excess))


def effects_of(found: Explained) -> tuple[PlacedEffect, ...]:
    return cast(tuple[PlacedEffect, ...], found.model.effects)


class Machine:
    """What the sets of some effects leave."""

    def __init__(self, effects: Sequence[PlacedEffect], left: Callable[[Sequence[PlacedEffect]], Array]) -> None:
        self.effects, self.left = effects, left

    def explain(self, effects: tuple[PlacedEffect, ...]) -> Explained:
        return explained(effects, self.left(effects))

    def candidates(self, model: Any, *_: object) -> SimpleNamespace:  # noqa: ANN401 (a model's double)
        return SimpleNamespace(placed=[e for e in self.effects if e not in model.effects], refused={})

    def rank(self, _: Bench, base: Explained, placed: Sequence[PlacedEffect], __: object) -> Ranking:
        found = [candidate(base, self.explain((*effects_of(base), effect))) for effect in placed]
        return Ranking(base, tuple(sorted(found, key=lambda c: -c.gain.total)))

    def on(self, _: Bench, below: Explained, above: Explained) -> Explained:
        return self.explain((*effects_of(below), effects_of(above)[-1]))


def candidate(base: Explained, found: Explained) -> Candidate:
    """One whose place the free parameters can take, once there is an effect."""
    gain = paired_gain(base.held_out, found.held_out, SETTINGS)
    known = Identifiability(alone=1e6, beside=1.0) if effects_of(base) else Identifiability(alone=1e4, beside=1e3)
    return Candidate(effects_of(found)[-1], found, gain, known, 1.0)


def climb(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> Ladder:
    """The ladder of a machine."""
    for name in ("candidates", "rank"):
        monkeypatch.setattr(ladder, name, getattr(machine, name))
    monkeypatch.setattr(ladder, "_on", machine.on)
    monkeypatch.setattr(ladder, "_as_good_as_it_can", lambda _, base, fewer, __: (fewer, base))
    nothing = cast(Any, None)
    return ladder.climb(BENCH, machine.explain(()), {}, nothing, nothing, most=4, watch=lambda _: lambda _: None)


def labels(effects: Sequence[PlacedEffect]) -> list[str]:
    return [effect.label for effect in effects]


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
    assert [step.explained.model.effects[-1].label for step in climbed.steps] == [SIMPLE.label]
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


@pytest.mark.parametrize(("base", "verdict"), [(WIDE, "unexplained"), (np.repeat(0.09, BLOCKS), "none")])
def test_where_all_that_was_added_is_dropped_nothing_is_named(base: Array, verdict: str) -> None:
    below = explained((), base)
    ranking = (candidate(below, explained((SIMPLE,), np.zeros(BLOCKS))),)
    rung = Rung(below, ranking, decide(below, ranking, SETTINGS))
    whole = Ladder((rung,), below, ())
    assert whole.verdict(SETTINGS) == "named"  # `most` is 0: nothing was tried beside it
    assert replace(whole, dropped=(SIMPLE.label,)).verdict(SETTINGS) == verdict
