"""Effects on trial beside effects that are beyond doubt, on models of which only the scores are known."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from diagnosis_machines import evidence_settings
from effect_machines import block, placed

from dr_lab.comparison.notes import put_back
from dr_lab.diagnosis.evidence.bench import Bench, FittedModel
from dr_lab.diagnosis.evidence.paired_gain import paired_gain, supported, worth_a_trial
from dr_lab.diagnosis.evidence.score import Score
from dr_lab.diagnosis.fit.identifiability import Identifiability
from dr_lab.diagnosis.search import ladder, pruning, restack
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.deletions import Deletions
from dr_lab.diagnosis.search.ladder import Ladder, Rung
from dr_lab.diagnosis.search.pruning import PutBack
from dr_lab.diagnosis.search.rank import Ranking
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.diagnosis.search.verdict import decide
from dr_lab.effects.catalogue import SpecialCases
from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.context import ContextEstimate, ContextSpace
from dr_lab.trajectory import Array

SETTINGS = evidence_settings()
BLOCKS, WINDOWS, COUNT = 10, 30, 300.0  # three windows a block, one log
NOISE = np.random.default_rng(0).chisquare(COUNT, WINDOWS)
SIMPLE, RICH = (placed(block(), name, "rail") for name in ("coulomb_friction", "stribeck_friction"))
BENCH = cast(Bench, SimpleNamespace(evidence=SETTINGS, scored="held-out logs"))
WIDE = np.repeat(20.0, BLOCKS)
NOTHING = cast(Any, None)
SCATTERED = np.array([1.0, 1.0, -0.3, 1.0, -0.3, 1.0, -0.3, -0.3, 1.0, -0.3])


def score(excess: Array) -> Score:
    """χ² per sample beyond the noise's, by block."""
    sums = NOISE + COUNT * np.repeat(excess, WINDOWS // BLOCKS)
    counts = np.full(WINDOWS, COUNT)
    return Score(float(sums.sum() / counts.sum()), {}, {}, {}, sums, counts, np.zeros(WINDOWS, np.intp), 0)


def fitted_model(effects: Sequence[PlacedEffect], excess: Array) -> FittedModel:
    model, fit = SimpleNamespace(effects=tuple(effects)), SimpleNamespace(below=lambda _: 0.0)
    return FittedModel(cast(Any, model), cast(Any, fit), cast(Any, None), score(excess))


def effects_of(found: FittedModel) -> tuple[PlacedEffect, ...]:
    return cast(tuple[PlacedEffect, ...], found.model.effects)


class Machine:
    """What the sets of some effects leave."""

    def __init__(
        self,
        effects: Sequence[PlacedEffect],
        left: Callable[[Sequence[PlacedEffect]], Array],
        known: Mapping[str, tuple[float, float]] | None = None,
    ) -> None:
        self.effects, self.left, self.known = effects, left, known or {}

    def explain(self, effects: tuple[PlacedEffect, ...]) -> FittedModel:
        return fitted_model(effects, self.left(effects))

    def candidates(self, model: Any, *_: object) -> SimpleNamespace:  # noqa: ANN401 (a model's double)
        return SimpleNamespace(placed=[e for e in self.effects if e not in model.effects], refused={})

    def rank(self, _: Bench, base: FittedModel, placed: Sequence[PlacedEffect], __: object) -> Ranking:
        found = [candidate(base, self.explain((*effects_of(base), effect))) for effect in placed]
        return Ranking(base, tuple(sorted(found, key=lambda c: -c.gain.total)))

    def on(self, _: Bench, below: FittedModel, above: FittedModel, __: float) -> FittedModel:
        return self.explain((*effects_of(below), effects_of(above)[-1]))

    def special_cases(self, richer: PlacedEffect, model: Any) -> list[PlacedEffect]:  # noqa: ANN401 (a model's double)
        free = (effect for effect in self.effects if effect not in model.effects)
        return [effect for effect in free if effect.effect.name in richer.effect.holds]

    def known_of(self, _: Bench, found: FittedModel) -> ContextEstimate:
        """Parameters beyond doubt, but for those of which other values and standard deviations are known."""
        space = ContextSpace(tuple(p for effect in effects_of(found) for p in effect.parameters))
        known = [self.known.get(name, (1.0, 0.01)) for name in space.names]
        return ContextEstimate(space, np.array([value for value, _ in known]), np.diag([std**2 for _, std in known]))

    def made(self, swap: Any, found: FittedModel) -> FittedModel:  # noqa: ANN401 (private)
        return self.explain(tuple(swap.poorer if e.label == swap.richer.label else e for e in effects_of(found)))


def candidate(base: FittedModel, found: FittedModel) -> Candidate:
    """One whose place the free parameters can take, once there is an effect."""
    gain = paired_gain(base.held_out, found.held_out, SETTINGS)
    known = Identifiability(alone=1e6, beside=1.0) if effects_of(base) else Identifiability(alone=1e4, beside=1e3)
    return Candidate(effects_of(found)[-1], found, gain, known, 1.0)


def climb(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> Ladder:
    """The ladder of a machine."""
    prepare(machine, monkeypatch)
    return ladder.climb(BENCH, machine.explain(()), {}, NOTHING, NOTHING, most=4, watch=lambda _: lambda _: None)


def prepare(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let nothing be simulated."""
    for name in ("candidates", "rank"):
        monkeypatch.setattr(ladder, name, getattr(machine, name))
    monkeypatch.setattr(restack, "_on", machine.on)
    monkeypatch.setattr(Deletions, "_as_good_as_it_can", lambda _, base, fewer, *__: (fewer, base))
    monkeypatch.setattr(pruning, "beyond_doubt", lambda *_: np.inf)
    monkeypatch.setattr(pruning, "known_of", machine.known_of)
    monkeypatch.setattr(SpecialCases, "of", lambda _, richer, model: machine.special_cases(richer, model))
    monkeypatch.setattr(
        "dr_lab.diagnosis.search.pruning._Swap.made", lambda swap, _, __, found, *___: machine.made(swap, found)
    )


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


@pytest.mark.parametrize(("base", "verdict"), [(WIDE, "unexplained"), (np.repeat(0.09, BLOCKS), "none")])
def test_where_all_that_was_added_is_dropped_nothing_is_named(base: Array, verdict: str) -> None:
    below = fitted_model((), base)
    ranking = (candidate(below, fitted_model((SIMPLE,), np.zeros(BLOCKS))),)
    rung = Rung(below, ranking, decide(below, ranking, SETTINGS))
    whole = Ladder((rung,), below, ())
    assert whole.verdict(SETTINGS) == "named"  # `most` is 0: nothing was tried beside it
    assert replace(whole, dropped=(SIMPLE.label,)).verdict(SETTINGS) == verdict


SKEW, TILT, SOFT = (placed(block(), name, "rail") for name in ("asymmetric_friction", "constant_offset", "armature"))
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


@pytest.mark.parametrize(("std", "stays"), [(0.01, SKEW), (0.1, SIMPLE)])
def test_a_richer_effect_stands_if_the_scatter_between_logs_lets_it(
    std: float, stays: PlacedEffect, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It explains more of the held-out logs; alone it is judged when the climb is over."""

    def left(effects: Sequence[PlacedEffect]) -> Array:
        return np.repeat(0.0 if SKEW in effects else 1.0 if SIMPLE in effects else 20.0, BLOCKS)

    climbed = climb(Machine((SIMPLE, SKEW), left, {ASYMMETRY: (0.2, std)}), monkeypatch)
    assert labels(effects_of(climbed.models[-1])) == [stays.label]
    assert [back.compatible for back in climbed.put_back] == ([True] if stays is SIMPLE else [])


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


def test_an_effect_compatible_with_its_absence_does_not_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    def left(effects: Sequence[PlacedEffect]) -> Array:
        return np.zeros(BLOCKS) if TILT in effects else WIDE

    name = TILT.parameters[0].name
    assert climb(Machine((TILT,), left, {name: (1.0, 0.35)}), monkeypatch).dropped == ()
    climbed = climb(Machine((TILT,), left, {name: (1.0, 0.5)}), monkeypatch)
    assert (climbed.steps, climbed.dropped) == ((), (TILT.label,))
    assert climbed.verdict(SETTINGS) == "unexplained"


def test_rivals_that_are_richer_kinds_of_what_is_put_back_are_none_any_more(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = Machine((SIMPLE, SKEW), beside_a_tilt, {ASYMMETRY: (0.0, 0.1)})
    prepare(machine, monkeypatch)
    base = machine.explain(())
    rivals = tuple(candidate(base, machine.explain((each,))) for each in (SIMPLE, RICH, SOFT))
    steps = (AddedEffect(machine.explain((SKEW,)), rivals), AddedEffect(machine.explain((SKEW, TILT)), ()))
    found = pruning.lean(Deletions(BENCH), base, steps, SpecialCases({}, NOTHING, NOTHING))
    assert [rival.effect.label for rival in found.steps[0].rivals] == [SOFT.label]


def test_a_report_tells_what_was_put_back_and_why() -> None:
    found = PutBack(SKEW.label, SIMPLE.label, {"asymmetry": (0.0004, 0.0054)}, compatible=True)
    told, other = (note.message for note in put_back([found, replace(found, compatible=False)]))
    assert told == (
        "asymmetric_friction@rail was put back to coulomb_friction@rail: its further parameters are compatible with "
        "nothing (asymmetry 0.0004 ± 0.0054)."
    )
    assert "explain no more" in other
