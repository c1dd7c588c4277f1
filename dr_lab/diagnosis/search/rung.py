"""One rung of a ladder: a model, what was ranked beside it, and what to add."""

from dataclasses import dataclass
from math import inf

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel
from dr_lab.diagnosis.search.as_special_case import holds
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.diagnosis.search.verdict import Verdict, decide


@dataclass(frozen=True)
class Rung:
    """One model that was judged, and what the catalogue could do for it.

    Attributes:
        base: the model, refitted and scored.
        ranking: the candidates beside it, best first.
        verdict: the judgement on them.
    """

    base: FittedModel
    ranking: tuple[Candidate, ...]
    verdict: Verdict

    @classmethod
    def judged(cls, bench: Bench, base: FittedModel, ranking: tuple[Candidate, ...]) -> "Rung":
        """The rung of a ranking beside a model, by the rules of a bench."""
        return cls(base, ranking, decide(base, ranking, bench.evidence, bench.scored))

    @property
    def alike(self) -> bool:
        """Whether one effect alone was compared, at several sites or at one."""
        return len({c.effect.effect.name for c in self.ranking}) == 1

    def step(self) -> AddedEffect:
        """The first effect that it names, or else finds worth a trial, with what may yet take its place.

        There must be one. A candidate that it beats, but that explains more than one of its rivals, may.
        """
        found, named = {c.effect.label: c for c in self.ranking}, self.verdict.effects
        chosen, *rivals = (found[label] for label in named or self.verdict.trial)
        least = min((each.gain.total for each in rivals), default=inf)
        status = self.verdict.status
        left = ("rejected", "not_needed")
        passed = (c for c in self.ranking if c.final and c.resolved and status[c.effect.label] in left)
        near = tuple(c for c in passed if c.gain.total > least and not holds(c.effect, chosen.effect))
        return AddedEffect(chosen.fitted_model, tuple(rivals), proven=bool(named), passed=near, alike=self.alike)
