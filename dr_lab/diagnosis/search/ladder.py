"""The ladder of models: the calibrated one, and each of those that has one effect more than the one below."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import mujoco

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, fitted_to_the_end
from dr_lab.diagnosis.evidence.confirmation import Confirmation
from dr_lab.diagnosis.evidence.noise_floor import at_floor
from dr_lab.diagnosis.evidence.paired_gain import Gain, paired_gain
from dr_lab.diagnosis.evidence.support import cleared
from dr_lab.diagnosis.search.deletions import Deletions
from dr_lab.diagnosis.search.law_check import LawCheck, check_laws
from dr_lab.diagnosis.search.pruning import Doubt, finished
from dr_lab.diagnosis.search.put_back import PutBack
from dr_lab.diagnosis.search.rung import Rung
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.effects.catalogue import SpecialCases
from dr_lab.effects.effect import Scales


@dataclass(frozen=True)
class Ladder:
    """A climbed ladder.

    Attributes:
        rungs: the rankings, in the order in which they were made.
        base: the calibrated model.
        steps: the added effects, in order.
        refused: why effects of the catalogue were not tried at a site, by ``effect@site``.
        dropped: labels of effects that were added, but without which the logs are explained as well in the end.
        put_back: effects that were added, but whose place one of their special cases has taken.
        laws: what free laws explain beside the added effects; empty where none was checked.
        confirmation: what those windows say that took no part in choosing the effects; None without such windows.
        doubt: the effect that was dropped as the last one, where the end of the climb left none.
    """

    rungs: tuple[Rung, ...]
    base: FittedModel
    steps: tuple[AddedEffect, ...]
    refused: Mapping[str, str] = field(default_factory=dict)
    dropped: tuple[str, ...] = ()
    put_back: tuple[PutBack, ...] = ()
    laws: tuple[LawCheck, ...] = ()
    confirmation: Confirmation | None = None
    doubt: Doubt | None = None

    @property
    def absorbed(self) -> tuple[str, ...]:
        """Labels of effects whose place the free parameters can take, by the last rung whose model still stands."""
        return [r for r in self.rungs if any(r.base is model for model in self.models)][-1].verdict.absorbed

    @property
    def refuted(self) -> set[str]:
        """Labels of effects that were added and do not stand: they are not tried again."""
        return {*self.dropped, *(back.richer for back in self.put_back)}

    @property
    def found(self) -> tuple[str, ...]:
        """Labels of the effects that were added, those that were dropped again first."""
        return tuple(dict.fromkeys((*self.dropped, *(step.effect.label for step in self.steps))))

    @property
    def models(self) -> tuple[FittedModel, ...]:
        """The ladder's models, the calibrated one first."""
        return (self.base, *(step.fitted_model for step in self.steps))

    def topped(self, last: FittedModel) -> "Ladder":
        """The ladder with a better fit of its last model; itself, whose deletions are known, where there is none."""
        if last is self.models[-1]:
            return self
        if not self.steps:
            return replace(self, base=last)
        return replace(self, steps=(*self.steps[:-1], replace(self.steps[-1], fitted_model=last)))

    def ended(self, bench: Bench) -> "Ladder":
        """The ladder with its last model, which is the answer, fitted to the end; in the rung that judged it, too."""
        last, end = self.models[-1], fitted_to_the_end(bench, self.models[-1])
        rungs = tuple(replace(rung, base=end) if rung.base is last else rung for rung in self.rungs)
        return replace(self.topped(end), rungs=rungs)

    def gained(self, settings: EvidenceSettings) -> Gain:
        """What all added effects gain together over the calibrated model."""
        return paired_gain(self.base.held_out, self.models[-1].held_out, settings)

    def closed(self, settings: EvidenceSettings) -> float:
        """Share of the calibrated model's gap that all effects close; 1 where they bring a channel to its floor.

        Within a short window fitted starts take up what a model lacks, such as a force that beats or a mass that
        sloshes. So the share is computed twice, with fitted starts and with starts that only earlier samples tell
        (where these are known), and the smaller one counts.
        """
        gain = self.gained(settings)
        if cleared(self.base.held_out, self.models[-1].held_out, gain, settings):
            return 1.0
        return gain.gap if self.confirmation is None else min(gain.gap, self.confirmation.predicted.gain.gap)

    def verdict(self, settings: EvidenceSettings) -> str:
        """What was found, by the first of these rules that holds.

        1. Without an added effect it is the first rung's verdict. If all that was added was dropped again, it is
           ``none`` at the noise floor and ``unexplained`` above.
        2. It is ``unexplained`` if the effects leave much of the gap, and more than noise: they are what the catalogue
           has nearest to the cause, rather than the cause.
        3. It is ``unexplained`` if an effect has another law than the machine, or if windows that took no part in
           choosing the effects contradict them.
        4. It is ``equivalent`` if an effect has rivals, otherwise ``named``.
        """
        noise = at_floor(self.models[-1].held_out, settings)
        if not self.steps:
            first = self.rungs[0].verdict
            return ("none" if noise else "unexplained") if first.effects and self.dropped else first.kind
        if not noise and self.closed(settings) < settings.least_named:
            return "unexplained"
        if any(law.refuted for law in self.laws) or (self.confirmation and self.confirmation.contradicts):
            return "unexplained"
        return "equivalent" if any(step.rivals for step in self.steps) else "named"

    def confirmed_by(self, found: Confirmation | None, settings: EvidenceSettings) -> "Ladder":
        """The ladder with what other windows say; without its effects where these contradict what was only noise."""
        if found is None or not found.contradicts or not at_floor(self.base.held_out, settings):
            return replace(self, confirmation=found)
        dropped = (*self.dropped, *(step.effect.label for step in self.steps))
        return replace(self, steps=(), dropped=dropped, confirmation=found)

    def without_last(self) -> "Ladder":
        """The ladder without its last effect, which is dropped."""
        return replace(self, steps=self.steps[:-1], dropped=(*self.dropped, self.steps[-1].effect.label))

    def with_laws(self, bench: Bench, scales: Scales, compiled: mujoco.MjModel) -> "Ladder":
        """The ladder with the laws of its effects checked; scales and nominal model as for `climb`."""
        return replace(self, laws=check_laws(bench, self.steps, scales, compiled))

    def with_first_step(self) -> "Ladder":
        """The ladder with the effect that its first rung names, where it names one."""
        return replace(self, steps=(self.rungs[0].step(),) if self.rungs[0].verdict.effects else ())

    def pruned(self, bench: Bench, cases: SpecialCases) -> "Ladder":
        """The ladder with no more effects, and none richer, than the logs ask for; see `pruning.finished`."""
        found = finished(Deletions(bench), self.base, self.steps, cases)
        return replace(self, steps=found.steps, dropped=found.dropped, put_back=found.put_back, doubt=found.doubt)
