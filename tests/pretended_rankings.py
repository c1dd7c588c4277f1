"""Rankings of which only the scores are known."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
from diagnosis_machines import evidence_settings
from effect_machines import block, placed

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.evidence.paired_gain import paired_gain
from dr_lab.diagnosis.evidence.score import Score
from dr_lab.diagnosis.fit.identifiability import Identifiability
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.verdict import Verdict, decide

SETTINGS = evidence_settings()
WINDOWS, COUNT = 30, 300.0
NOISE = np.random.default_rng(0).chisquare(COUNT, WINDOWS)
CLEAR, HIDDEN = Identifiability(alone=1e4, beside=1e3), Identifiability(alone=1.0, beside=0.5)
ABSORBED = Identifiability(alone=1e6, beside=1.0)


def score(level: float, seed: int = 0) -> Score:
    """A χ² per sample of about `level` in every window, the same noise below all models."""
    extra = (level - 1) * COUNT * np.random.default_rng(seed).uniform(0.5, 1.5, WINDOWS)
    sums = NOISE + extra
    return Score(
        float(sums.sum() / COUNT / WINDOWS), {}, {}, {}, sums, np.full(WINDOWS, COUNT), np.arange(WINDOWS) // 10, 0
    )


def wild(level: float) -> Score:
    """The same, but for one window far off."""
    whole = score(level)
    sums = whole.window_sum.copy()
    sums[7] = 700.0 * COUNT
    return replace(whole, chi2=float(sums.sum() / COUNT / WINDOWS), window_sum=sums)


@dataclass(frozen=True)
class Fitted:
    """A fit of which only the cost is known, and the values if asked for."""

    cost: float
    z: None = None

    def below(self, other: "Fitted") -> float:
        """By how much the cost is below another's."""
        return other.cost - self.cost


def model(level: float | Score, cost: float = 0.0) -> FittedModel:
    nothing = cast(Any, None)
    return FittedModel(nothing, cast(Any, Fitted(cost)), nothing, level if isinstance(level, Score) else score(level))


def candidate(
    base: FittedModel, name: str, level: float | Score, known: Identifiability, cost: float = 0.0
) -> Candidate:
    return at_values(base, name, level, {}, known, cost)


def at_values(
    base: FittedModel,
    name: str,
    level: float | Score,
    values: Mapping[str, float],
    known: Identifiability = CLEAR,
    cost: float = 0.0,
) -> Candidate:
    """A candidate whose parameters ended at these values, by short names; the others at absent."""
    site = "drive" if name in ("actuator_delay", "saturation", "torque_scale") else "rail"
    effect = placed(block(), name, site)
    ended = {p.name: p.nominal for p in effect.parameters} | {f"{effect.label}.{n}": v for n, v in values.items()}
    space = SimpleNamespace(mapping=lambda _: ended)
    fitted_model = replace(model(level, cost), model=cast(Any, SimpleNamespace(space=space)))
    gain = paired_gain(base.held_out, fitted_model.held_out, SETTINGS)
    return Candidate(effect, fitted_model, gain, known, 1.0, cast(Any, None))


def judged(level: float | Score, *levels: tuple[str, float | Score], **known: Identifiability) -> Verdict:
    """Verdict on effects that bring the χ² to a level each; `known` by effect."""
    base = model(level)
    ranking = [candidate(base, name, each, known.get(name, CLEAR)) for name, each in levels]
    return decide(base, sorted(ranking, key=lambda c: -c.gain.total), SETTINGS)


def few(level: float) -> Score:
    """One window of one log."""
    whole = score(level)
    one = np.arange(1)
    return replace(whole, window_sum=whole.window_sum[one], window_count=whole.window_count[one], log=whole.log[one])
