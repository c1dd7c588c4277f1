"""What is put back to a special case of it, and why: whether the logs ask for the richer of two effects."""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, fit_and_score
from dr_lab.diagnosis.evidence.compatible import chance, known_of
from dr_lab.diagnosis.evidence.likelihood import less_likely
from dr_lab.diagnosis.evidence.noise_floor import at_floor
from dr_lab.diagnosis.evidence.paired_gain import paired_gain
from dr_lab.diagnosis.evidence.support import supported_in_all_logs, supported_within_logs
from dr_lab.diagnosis.fit.covariance import clusters
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.effects.effect import PlacedEffect
from dr_lab.effects.special_case import SpecialCase
from dr_lab.physics.context import ContextEstimate, ContextSpace
from dr_lab.physics.model import Model
from dr_lab.physics.model_effect import ModelEffect
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class PutBack:
    """An effect whose place one of its special cases has taken.

    Attributes:
        richer: its label.
        poorer: the special case's.
        further: value and standard deviation of the parameters that the special case lacks, by short names.
        compatible: whether these are compatible with zero, given the scatter between logs. Otherwise the effect was put
            back because the logs that score do not ask for them.
        certain: whether they differ from zero beyond doubt although few logs show their scatter badly.
        at_limit: whether they ended at their bounds next to zero, where the effect is the special case.
        little: whether they close little of the little that the poorer model leaves beyond the noise.
        hidden: whether the time step of the model does much of what they change.
    """

    richer: str
    poorer: str
    further: Mapping[str, tuple[float, float]]
    compatible: bool
    certain: bool
    at_limit: bool = False
    little: bool = False
    hidden: bool = False


def asked_for(poorer: FittedModel, richer: FittedModel, back: PutBack, extra: int, settings: EvidenceSettings) -> bool:
    """Whether the logs ask for the richer of two models, which has so many parameters more.

    They do not where its further parameters ended next to zero: what it gains there is by how it is computed. Else they
    do in two cases:

    1. The windows that score support it, and its further parameters differ from zero beyond doubt, given the scatter
       between logs. Where they do so even by F, which knows how few the logs are, the windows need not gain alike in
       all logs: a log that hardly excites the parameters gains little.
    2. It leaves noise, and the poorer one is less likely. Then it is no wrong model whose errors scatter from log to
       log. Where the poorer one leaves noise as well, the further parameters must also differ from zero as above.
    """
    if back.at_limit:
        return False
    if at_floor(richer.held_out, settings) and less_likely(poorer, richer, extra, settings):
        return not back.compatible or not at_floor(poorer.held_out, settings)
    gain, enough = paired_gain(poorer.held_out, richer.held_out, settings), supported_in_all_logs
    if back.certain:
        enough = supported_within_logs
    return not back.compatible and enough(gain, extra, settings)


def closes_little(poorer: FittedModel, richer: FittedModel, settings: EvidenceSettings) -> bool:
    """Whether the richer of two models leaves most of a gap that hardly shows, in the channel with the most evidence.

    Of a gap g = χ² − 1 of the poorer model a cause closes the share `least_named`, s, or more. A model with the wrong
    law may close less, also beyond doubt: everything that is small and regular, such as the time step of another
    simulator, moves the parameters of some law away from zero. Where s g is more than what the noise is known to
    (`floor` − 1) the richer model shows itself whether it leaves noise. So only smaller gaps are asked. What the
    richer model leaves is no gap where it is such as instruments make and no force does.
    """
    gain = paired_gain(poorer.held_out, richer.held_out, settings)
    channel, left = (each.held_out.channels.get(gain.place) for each in (poorer, richer))
    if left is not None and left.instrumental:
        return False
    gap = (poorer.held_out.chi2 if channel is None else channel.chi2) - 1
    hardly = settings.least_named * gap < settings.floor - 1
    return hardly and gain.channels.get(gain.place, 1.0) < settings.least_named


@dataclass(frozen=True)
class Swap:
    """A special case in the place of a richer effect.

    Attributes:
        richer: the effect.
        poorer: the special case.
    """

    richer: PlacedEffect
    poorer: PlacedEffect

    @property
    def case(self) -> SpecialCase:
        """How the richer one becomes the poorer one."""
        return self.richer.effect.holds[self.poorer.effect.name]

    @property
    def _shapes(self) -> list[str]:
        """Parameters of the richer effect that mean nothing in the poorer one."""
        rest = [name for name in self.richer.effect.shapes if name not in self.case.further]
        return [f"{self.richer.label}.{name}" for name in rest]

    def put_back(self, bench: Bench, whole: FittedModel) -> PutBack:
        """What the richer effect has beyond the poorer one, as fitted in a model that contains it."""
        known, names = known_of(bench, whole), {f"{self.richer.label}.{name}": name for name in self.case.further}
        rows = [known.space.index(name) for name in names]
        values = zip(known.mean[rows].tolist(), known.std[rows].tolist(), strict=True)
        none, freedom = dict.fromkeys(names, 0.0), max(len(clusters(bench.fit, bench.evidence)) - 1, 1)
        doubts = [chance(known, none, self._shapes, each) for each in (np.inf, freedom)]
        compatible, uncertain = (doubt >= 1 - bench.evidence.confidence for doubt in doubts)
        further = dict(zip(names.values(), values, strict=True))
        return PutBack(
            self.richer.label,
            self.poorer.label,
            further,
            compatible,
            not uncertain,
            self._at_limit(known, none, 1 - bench.evidence.confidence),
        )

    @staticmethod
    def _at_limit(known: ContextEstimate, none: Mapping[str, float], doubt: float) -> bool:
        """Whether further parameters ended at a bound next to zero, and the others are compatible with zero."""
        ended = {name for name in none if _next_to_zero(known, name)}
        rest = {name: zero for name, zero in none.items() if name not in ended}
        return bool(ended) and (not rest or chance(known, rest) >= doubt)

    def effects(self, model: Model) -> list[ModelEffect]:
        """The effects of a model, with the poorer one in place of the richer one."""
        return [self.poorer if effect.label == self.richer.label else effect for effect in model.effects]

    def made(self, bench: Bench, base: FittedModel, fitted_model: FittedModel, goal: float = np.inf) -> FittedModel:
        """The model with the poorer effect, fitted from where the richer one's ended; of a `goal` see `Fitter.run`."""
        added = self.effects(fitted_model.model)[len(base.model.effects) :]
        model = functools.reduce(Model.with_effect, added, base.model)
        starts, delta = self._starts(model.space, fitted_model.values()), fitted_model.fit.delta
        found = (fit_and_score(bench, model, z, delta, goal) for z in starts)
        return min(found, key=lambda each: each.fit.order)

    def _starts(self, space: ContextSpace, values: Mapping[str, float]) -> Sequence[Array]:
        """Starts of the poorer effect: the richer one's values if they mean the same, else its own starts."""
        rest = {name: value for name, value in values.items() if name in space.names}
        ours, theirs = self.poorer.label, self.richer.label
        same = {f"{ours}.{to}": values[f"{theirs}.{name}"] for name, to in self.case.same.items()}
        starts = [same] if same else self.poorer.starts or [{}]
        return [space.clip(space.vector({**rest, **start})) for start in starts]

    def rivals(self, step: AddedEffect) -> tuple[Candidate, ...]:
        """The step's rivals, without the poorer effect itself and without other richer kinds of it at its site."""
        name, site = self.poorer.effect.name, self.poorer.site
        near = (c for c in step.rivals if c.effect.site == site)
        needless = [c for c in near if name in (c.effect.effect.name, *c.effect.effect.holds)]
        return tuple(c for c in step.rivals if c not in needless)


def _next_to_zero(known: ContextEstimate, name: str) -> bool:
    row = known.space.index(name)
    parameter = known.space.parameters[row]
    return parameter.low >= 0.0 and parameter.ends(known.mean[row])[0]
