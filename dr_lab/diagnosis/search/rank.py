"""Rank the catalogue: every effect at every site.

Most candidates are out after a linear step on few windows. A fit to these windows decides between most of the others.
Only those that stand are fitted to all windows, so the cost hardly grows with the catalogue or the length of the logs.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, scored
from dr_lab.diagnosis.evidence.noise_floor import at_floor
from dr_lab.diagnosis.evidence.paired_gain import paired_gain
from dr_lab.diagnosis.evidence.support import supported
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.search.as_special_case import holds, special_cases
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.candidate_fits import CandidateFits
from dr_lab.diagnosis.search.refits import Refits
from dr_lab.diagnosis.search.waves import Waves
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.effects.effect import PlacedEffect

_NONE: Mapping[int, Candidate] = {}


class Ranking(NamedTuple):
    """Candidates beside one model.

    Attributes:
        base: the model without them; a better fit than the given one if a candidate's fit led to it.
        candidates: most evidence first, equal evidence by fewest parameters.
        back_from: the candidate's fit from whose end the base was fitted anew; None where none was worth it.
    """

    base: FittedModel
    candidates: tuple[Candidate, ...]
    back_from: Fit | None = None


def rank(bench: Bench, base: FittedModel, placed: Sequence[PlacedEffect], done: Callable[[str], None]) -> Ranking:
    """Rank candidates beside a fitted model; `done` is told each label.

    1. Each is linearised at absent and at its further starts, on a part of the windows (`Bench.screening`).
    2. Those that promise enough are fitted there, half of them with a single parameter, the most promising one first:
       others are given up where they are foretold to stay behind it beyond doubt. Each brings its special cases along.
       If these gain less than promised, a second wave is fitted of those that promise about as much as the first
       gained. So are half as many that promise most in typical windows, which a few wild ones hide. In the end those
       are, too, that hold the best one, or one there like it, as a special case or are confused with it, and those that
       promise more than it gained: other kinds may have crowded them out.
    3. The best one and those that it does not beat there are fitted to all windows and scored on the held-out ones,
       except those that hardly explain more than a special case of theirs, or that are foretold not to get below one
       that is their limit, or to stay behind the first one fitted beyond doubt. Richer kinds of the one with most
       evidence are asked again there: few windows may not show what they add. The best one then goes on beyond bounds
       that are no physics, where it ran into them.
    4. If the data support none of these, those have their turn that had stood behind one that gains nothing on all
       windows, and as many others: those that promise most in typical windows, for what promises most in all may meet
       a few wild ones alone. They bring along what may have been crowded out, as in rule 2, and must stand beside the
       first, too.
    5. The model without them is fitted anew from where the best of these and those that it does not beat ended, with
       the effect absent. If that is better than the base, it becomes the base, and candidates get no credit for it.

    If the base became better beyond doubt, all candidates are ranked anew beside it. They run side by side and share
    the threads, so that no core is asked for twice. A failure or Ctrl-C ends all of them at their next simulation.
    """
    ranking = _Contest(bench, base, placed, done).ranking()
    for _ in range(bench.evidence.rerankings):
        gained = paired_gain(base.held_out, ranking.base.held_out, bench.evidence)
        if not supported(gained, 0, bench.evidence):
            break
        base = ranking.base
        ranking = _Contest(bench, base, placed, done).ranking()
    return ranking._replace(candidates=tuple(candidate.told() for candidate in ranking.candidates))


class _Contest:
    """One ranking under way."""

    def __init__(
        self, bench: Bench, base: FittedModel, placed: Sequence[PlacedEffect], done: Callable[[str], None]
    ) -> None:
        self.bench, self.base = bench.beside(base), base
        self.fits = CandidateFits(self.bench, base)
        self.refits = Refits(self.fits)
        self.waves = Waves(self.fits, placed, done)
        self.placed = self.waves.placed

    def ranking(self) -> Ranking:
        """All candidates, and the base that they are compared with."""
        first = self.waves.first()
        found = self.final(first)
        if not any(map(self._supported, found.values())):
            others = {k: c for k, c in first.items() if found[k].fitted}  # few windows flattered those left absent
            waiting = {k: c for k, c in others.items() if not found[k].final}
            found |= self.final(waiting | self.waves.next(), others)
        return self.credited(_ordered([*found.values(), *self.waves.unfitted(found).values()]))

    def final(self, tried: Mapping[int, Candidate], before: Mapping[int, Candidate] = _NONE) -> dict[int, Candidate]:
        """The candidates by place; those that stand are fitted to all windows.

        Args:
            tried: fitted to few windows.
            before: others of which this was asked, fitted to few windows; those tried must stand beside them, too.
        """
        found = dict(tried)
        if not self.fits.whole:
            standing, needless = self._standing({**before, **tried})
            standing = [k for k in standing if k in tried]
            found |= {k: replace(found[k], needless=True) for k in needless if k in tried}
            cases = special_cases(self.placed, standing, standing)
            others = [k for k in standing if k not in cases]
            limits = {k: j for k in others for j in standing if holds(self.placed[k], self.placed[j])}
            alone = [k for k in others if k not in limits]
            beaten = self._refit_alone(alone, found) if alone else np.inf
            found |= self._refit_near(limits, partial(self.refits.refitted_beyond, beaten=beaten), found)
            found |= self._refit_near(cases, partial(self.refits.refitted_beside, beaten=beaten), found)
            self._ask_richer([k for k, c in found.items() if c.fitted and k not in standing], found)
            self._go_farther(found)
        return found

    @staticmethod
    def _best(tried: Mapping[int, Candidate]) -> int | None:
        """Place of the candidate with most evidence among those that are fitted to all windows."""
        return max((k for k, c in tried.items() if c.final), key=lambda k: tried[k].gain.total, default=None)

    def _supported(self, candidate: Candidate) -> bool:
        """Whether the data support a candidate, by its fit to all windows."""
        return candidate.final and supported(candidate.gain, len(candidate.effect.parameters), self.bench.evidence)

    def _ask_richer(self, places: Sequence[int], tried: dict[int, Candidate]) -> None:
        """Fit richer kinds of the best candidate to all windows where these show what the few windows did not."""
        best = self._best(tried)
        if best is None:
            return
        richer = [k for k in places if holds(self.placed[k], self.placed[best])]
        cases = special_cases(self.placed, richer, [best])
        limits = {k: best for k in richer if k not in cases}
        tried |= self._refit_near(cases, self.refits.refitted_beside, tried)
        tried |= self._refit_near(limits, self.refits.refitted_if_promising, tried)

    def _go_farther(self, tried: dict[int, Candidate]) -> None:
        """Go on with the best candidate's fit where it ran into a bound which is no physics.

        Few windows may not have shown that. One of which a special case explains as much, or leaves noise, may well end
        there.
        """
        for _ in range(self.bench.evidence.widenings):
            best = self._best(tried)
            if best is None:
                return
            cases = [c for k, c in tried.items() if c.final and holds(self.placed[best], self.placed[k])]
            worth = all(self._leaves_more(case, tried[best]) for case in cases)
            moved = self.fits.farther(tried[best], self.bench.threads) if worth else None
            if moved is None:
                return
            tried[best] = moved

    def _leaves_more(self, case: Candidate, candidate: Candidate) -> bool:
        """Whether a special case of a candidate leaves more than noise, and more than that, beyond doubt."""
        if at_floor(case.fitted_model.held_out, self.bench.evidence):
            return False
        gain = paired_gain(case.fitted_model.held_out, candidate.fitted_model.held_out, self.bench.evidence)
        return supported(gain, len(candidate.effect.parameters) - len(case.effect.parameters), self.bench.evidence)

    def _refit_near(
        self, near: Mapping[int, int], refitted: Callable[..., Candidate], tried: Mapping[int, Candidate]
    ) -> dict[int, Candidate]:
        """Candidates fitted to all windows beside another one, whose place is given for each."""
        threads = self.fits.threads_of(len(near))
        return self.fits.of([*near], lambda k: refitted(tried[k], tried[near[k]], threads=threads))

    def _refit_alone(self, places: Sequence[int], tried: dict[int, Candidate]) -> float:
        """Fit candidates to all windows, the one with the best start first; the cost above which that one beats others.

        What it leaves tells which others are worth their end.
        """
        share = self.fits.threads_of(len(places))
        starts = self.fits.side_by_side(places, lambda k: self.refits.begun(tried[k], share))
        begun = dict(zip(places, starts, strict=True))
        first, *others = sorted(places, key=lambda k: begun[k].start.cost)
        threads, share = self.bench.threads, self.fits.threads_of(len(others))
        tried |= self.fits.of([first], lambda k: self.refits.refitted(tried[k], begun[k], threads=threads))
        beaten = self.refits.beaten_by(tried[first])
        tried |= self.fits.of(others, lambda k: self.refits.refitted(tried[k], begun[k], beaten, share))
        return beaten

    def credited(self, found: tuple[Candidate, ...]) -> Ranking:
        """The ranking, with the base fitted anew from where the best candidates' fits ended, if that is better.

        Where several do equally well, it may be that none of them is missing, and each only moved the base on.
        """
        settings = self.bench.evidence
        credited = sorted((c for c in found if self._supported(c)), key=lambda c: c.fitted_model.fit.order)
        if not credited:
            return Ranking(self.base, found)
        leader, back_from = credited[0].fitted_model, credited[0].fitted_model.fit
        gains = (paired_gain(c.fitted_model.held_out, leader.held_out, settings) for c in credited)
        alike = [c for c, gain in zip(credited, gains, strict=True) if not supported(gain, 0, settings)]
        best = min((self.fits.without(c) for c in alike), key=lambda fit: fit.order)
        if self.base.fit.cost - best.cost <= self.bench.negligible_share * best.cost:
            return Ranking(self.base, found, back_from)
        base = scored(self.bench, self.base.model, best, near=self.base.states)
        return Ranking(base, beside(base, found, settings), back_from)

    def _standing(self, tried: Mapping[int, Candidate]) -> tuple[list[int], list[int]]:
        """Places of the best candidates and of all that the best one does not beat; of the latter, those needless.

        A needless one has more parameters than another that stands, and hardly explains more. A candidate whose fit
        gains less than is hoped for (`_gains`) is out, whatever was promised. Others stand as well, for few windows
        flatter the best one:

        1. Its special cases: a fit of hard friction ends early more often than one that softens it, so a richer effect
           may lead only because its fit went on.
        2. The best one of each smaller number of parameters: more of them bend to few windows more easily.
        """
        settings = self.bench.evidence
        order = sorted((k for k, c in tried.items() if self._gains(c)), key=lambda k: -tried[k].gain.total)
        if not order:
            return [], []
        standing, needless = list[int](), list[int]()
        counts = {k: len(tried[k].effect.parameters) for k in order}
        leaner = {counts[k]: k for k in reversed(order) if counts[k] < counts[order[0]]}  # the best one comes last
        kept = {*leaner.values(), *(k for k in order if holds(self.placed[order[0]], self.placed[k]))}
        for k in sorted(order, key=counts.__getitem__):
            best = paired_gain(tried[k].fitted_model.held_out, tried[order[0]].fitted_model.held_out, settings)
            cases = [
                j for j in standing if special_cases(self.placed, [k], [j])
            ]  # others may lead on few windows alone
            beaten = supported(best, 0, settings)
            if any(self._needless(tried[k], tried[j]) for j in cases or standing):
                needless += [] if beaten else [k]
            elif k in kept or not beaten:
                standing.append(k)
        return standing, needless

    def _gains(self, candidate: Candidate) -> bool:
        """Whether a fit to few windows gains as much as a linear step must promise, and not in the worst ones alone.

        Evidence that is negative in the very windows that were fitted is bought: a wild window is met at the cost of
        the typical ones.
        """
        start = self.fits.start
        gained = candidate.fitted_model.fit.below(start)
        enough = self.bench.promise(gained, start) >= self.bench.hope
        return candidate.fitted and enough and candidate.gain.total > 0

    def _needless(self, candidate: Candidate, other: Candidate) -> bool:
        """Whether a candidate with more parameters than another one hardly explains more."""
        more = len(candidate.effect.parameters) - len(other.effect.parameters)
        if more <= 0:
            return False
        ours, theirs = candidate.fitted_model.fit, other.fitted_model.fit
        return self.bench.beside(other.fitted_model).promise(ours.below(theirs), theirs, more) < self.bench.hope


def beside(base: FittedModel, found: Iterable[Candidate], settings: EvidenceSettings) -> tuple[Candidate, ...]:
    """Candidates beside a better fit of the model that they were ranked beside, most evidence first."""
    return _ordered(
        replace(c, gain=paired_gain(base.held_out, c.fitted_model.held_out, settings)) if c.final else c for c in found
    )


def _ordered(candidates: Iterable[Candidate]) -> tuple[Candidate, ...]:
    return tuple(sorted(candidates, key=lambda c: (-c.gain.total, len(c.effect.parameters))))
