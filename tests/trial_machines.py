"""A machine of which only the scores of its models are known: nothing is simulated when its ladder is climbed."""

from collections.abc import Callable, Mapping, Sequence
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from diagnosis_machines import evidence_settings
from effect_machines import block, placed

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel
from dr_lab.diagnosis.evidence.paired_gain import paired_gain
from dr_lab.diagnosis.evidence.score import Score
from dr_lab.diagnosis.fit.identifiability import Identifiability
from dr_lab.diagnosis.search import climb as climbing
from dr_lab.diagnosis.search import in_place, pruning, put_back, restack, step
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.climb_watch import Silence
from dr_lab.diagnosis.search.deletions import Deletions
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.diagnosis.search.rank import Ranking
from dr_lab.effects.catalogue import SpecialCases
from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.context import ContextEstimate, ContextSpace
from dr_lab.trajectory import Array

SETTINGS = evidence_settings()
BLOCKS, WINDOWS, COUNT = 10, 30, 300.0  # three windows a block, one log
NOISE = np.random.default_rng(0).chisquare(COUNT, WINDOWS)
SIMPLE, RICH = (placed(block(), name, "rail") for name in ("coulomb_friction", "stribeck_friction"))
LOGS = SimpleNamespace(channels=(), log=np.arange(30))
BENCH = cast(Bench, SimpleNamespace(evidence=SETTINGS, scored="held-out logs", fit=LOGS))
WIDE = np.repeat(20.0, BLOCKS)
SCATTERED = np.array([1.0, 1.0, -0.3, 1.0, -0.3, 1.0, -0.3, -0.3, 1.0, -0.3])  # a gain in doubt, by block
NOTHING = cast(Any, None)


def score(excess: Array) -> Score:
    """χ² per sample beyond the noise's, by block."""
    sums = NOISE + COUNT * np.repeat(excess, WINDOWS // BLOCKS)
    counts = np.full(WINDOWS, COUNT)
    return Score(float(sums.sum() / counts.sum()), {}, {}, {}, sums, counts, np.zeros(WINDOWS, np.intp), 0)


def fitted_model(effects: Sequence[PlacedEffect], excess: Array) -> FittedModel:
    absent = {p.name: p.nominal for effect in effects for p in effect.parameters}
    model = SimpleNamespace(effects=tuple(effects), space=SimpleNamespace(mapping=lambda _: absent))
    fit = SimpleNamespace(z=None, below=lambda _: 0.0, converged=True)
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
    return Candidate(effects_of(found)[-1], found, gain, known, 1.0, cast(Any, None))


def climb(machine: Machine, monkeypatch: pytest.MonkeyPatch, most: int = 4) -> Ladder:
    """The ladder of a machine."""
    prepare(machine, monkeypatch)
    begun = climbing.Climb.begun(BENCH, machine.explain(()))
    return climbing.climb(begun, {}, NOTHING, NOTHING, most=most, watch=Silence())


def prepare(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let nothing be simulated."""
    for name in ("candidates", "rank"):
        monkeypatch.setattr(climbing, name, getattr(machine, name))
    monkeypatch.setattr(in_place, "rank", machine.rank)
    monkeypatch.setattr(step, "fitted_for_comparison", lambda _, fitted_model: fitted_model)
    monkeypatch.setattr(restack, "_on", machine.on)
    monkeypatch.setattr(Deletions, "_as_good_as_it_can", lambda _, base, fewer, *__: (fewer, base))
    monkeypatch.setattr(pruning, "beyond_doubt", lambda *_: np.inf)
    monkeypatch.setattr(pruning, "hidden_by_step", lambda *_: False)
    monkeypatch.setattr(put_back, "known_of", machine.known_of)
    monkeypatch.setattr(pruning, "known", lambda _, found: SimpleNamespace(estimate=machine.known_of(_, found)))
    monkeypatch.setattr(SpecialCases, "of", lambda _, richer, model: machine.special_cases(richer, model))
    monkeypatch.setattr(
        "dr_lab.diagnosis.search.put_back.Swap.made", lambda swap, _, __, found, *___: machine.made(swap, found)
    )


def labels(effects: Sequence[PlacedEffect]) -> list[str]:
    return [effect.label for effect in effects]
