"""Rank the catalogue: every effect at every site.

Most candidates are out after a linear step on few windows. A fit to these windows decides between most of the others.
Only those that stand are fitted to all windows, so the cost hardly grows with the catalogue or the length of the logs.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple, TypeVar

import numpy as np

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, scored
from dr_lab.diagnosis.evidence.paired_gain import paired_gain, supported
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.search.as_special_case import special_case
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.candidate_fits import CandidateFits
from dr_lab.diagnosis.search.periods import with_periods
from dr_lab.diagnosis.search.refits import Refits
from dr_lab.diagnosis.search.screen import FirstLook
from dr_lab.diagnosis.search.shortlist import shortlist
from dr_lab.diagnosis.search.side_by_side import side_by_side
from dr_lab.effects.effect import PlacedEffect
from dr_lab.trajectory import Array

_In = TypeVar("_In")
_Out = TypeVar("_Out")


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
       others are given up where they are foretold to stay behind it beyond doubt. If these gain less than
       promised, a second wave is fitted of those that promise about as much as the first gained. In the end those are,
       too, that hold the best one as a special case or are confused with it: other kinds may have crowded them out.
    3. The best one and those that it does not beat there are fitted to all windows and scored on the held-out ones,
       except those that hardly explain more than a special case of theirs, or that are foretold not to get below one
       that is their limit, or to stay behind the first one fitted beyond doubt. Richer kinds of the one with most
       evidence are asked again there: few windows may not show what they add.
    4. The model without them is fitted anew from where the best of these ended, with the effect absent. If that is
       better than the base, it becomes the base, and candidates get no credit for it.

    If the base became better beyond doubt, all candidates are ranked anew beside it. They run side by side, one thread
    each, and one that others wait for on all threads, so that no core is asked for twice. A failure or Ctrl-C ends all
    of them at their next simulation.
    """
    ranking = _Contest(bench, base, placed, done).ranking()
    for _ in range(bench.solver.restarts):
        gained = paired_gain(base.held_out, ranking.base.held_out, bench.evidence)
        if not supported(gained, 0, bench.evidence):
            break
        base = ranking.base
        ranking = _Contest(bench, base, placed, done).ranking()
    return ranking


class _Contest:
    """One ranking under way."""

    def __init__(
        self, bench: Bench, base: FittedModel, placed: Sequence[PlacedEffect], done: Callable[[str], None]
    ) -> None:
        self.bench, self.base, self.done = bench.beside(base), base, done
        self.fits = CandidateFits(self.bench, base)
        self.refits = Refits(self.fits)
        self.placed = with_periods(self.fits.thin, base.model, self.fits.start, placed)

    def ranking(self) -> Ranking:
        """All candidates, and the base that they are compared with."""
        return self.credited(self.final(self.tried()))

    def tried(self) -> dict[int, Candidate]:
        """All candidates by place; those that promise enough are fitted to the screening windows and scored."""
        settings = self.bench.evidence
        looks = self._side_by_side(self.placed, self.fits.look)
        promise = np.array([self.bench.promise(each.gain, self.fits.start) for each in looks])
        self._ask_all_windows(promise, looks)
        order = [int(k) for k in np.argsort(-promise, kind="stable")]
        hopeful = [k for k in order if promise[k] >= self.bench.hope]
        found: dict[int, Candidate] = {}
        reachable = max((looks[k].gain for k in hopeful), default=0.0)
        for _ in range(2):
            near = [k for k in hopeful if looks[k].gain >= settings.least_promise * reachable]
            wave = shortlist([k for k in near if k not in found], self.placed, settings.most_fits - len(found))
            self._fit_wave(wave, looks, found)
            reachable = self._reached(found)
        self._fit_wave(self._crowded_out(hopeful, found), looks, found)
        self._widen(found)
        for k in set(order) - found.keys():
            found[k] = self._told(self.fits.unfitted(self.placed[k], looks[k]))
        return found

    def _crowded_out(self, hopeful: Sequence[int], found: dict[int, Candidate]) -> list[int]:
        """Hopeful effects, not fitted yet, at the site of the best fitted one, that are near it.

        They hold it, or what it holds, as a special case, or they say that they are confused with that.
        """
        best = max(found, key=lambda k: found[k].gain.total, default=None)
        if best is None:
            return []
        effect, site = self.placed[best].effect, self.placed[best].site
        poorer = {effect.name, *effect.holds}
        others = [k for k in hopeful if k not in found and self.placed[k].site == site]
        near = {k: {*self.placed[k].effect.holds, *self.placed[k].effect.confused_with} for k in others}
        return [k for k in others if poorer & near[k]]

    def _fit_wave(self, wave: list[int], looks: Sequence[FirstLook], found: dict[int, Candidate]) -> None:
        """Fit some candidates. An effect waits for its special case, to which it may have nothing to add."""
        wave.sort(key=lambda k: -len(self.placed[k].parameters))  # those that take longest begin
        cases = self._special_cases(wave, sorted({*wave, *found}))
        fits, placed = self.fits, self.placed
        alone = [k for k in wave if k not in cases]
        if alone and not found:  # what the most promising one leaves tells which others are worth their end
            first = max(alone, key=lambda k: looks[k].gain)
            threads = self.bench.threads
            self._do([first], lambda k: self._told(fits.fitted(placed[k], looks[k], threads=threads)), found)
            alone.remove(first)
        goal = fits.goal(list(found.values()))
        self._do(alone, lambda k: self._told(fits.fitted(placed[k], looks[k], goal)), found)
        self._do([*cases], lambda k: self._told(fits.fitted_beside(placed[k], looks[k], found[cases[k]])), found)

    def _widen(self, found: dict[int, Candidate]) -> None:
        """Go on with the fits that ran into a bound which is no physics, where they gain enough to matter."""
        settings, waiting = self.bench.evidence, list(found)
        for _ in range(settings.widenings):
            gained = {k: found[k].fitted_model.fit.below(self.fits.start) for k in waiting}
            waiting = [k for k, gain in gained.items() if gain >= settings.least_promise * self._reached(found)]
            farther = self._side_by_side([found[k] for k in waiting], self.fits.farther)
            moved = {k: candidate for k, candidate in zip(waiting, farther, strict=True) if candidate is not None}
            found |= moved
            waiting = list(moved)

    def _reached(self, found: dict[int, Candidate]) -> float:
        return max((c.fitted_model.fit.below(self.fits.start) for c in found.values()), default=0.0)

    def _told(self, candidate: Candidate) -> Candidate:
        self.done(candidate.effect.label)
        return candidate

    def final(self, tried: dict[int, Candidate]) -> tuple[Candidate, ...]:
        """The candidates, most evidence first; those that stand are fitted to all windows."""
        if not self.fits.whole:
            standing = self._standing(tried)
            cases = self._special_cases(standing, standing)
            limits = {k: j for k in standing for j in standing if k not in cases and self._holds(k, j)}
            alone = [k for k in standing if k not in cases and k not in limits]
            beaten = self._refit_alone(alone, tried) if alone else np.inf
            self._do([*limits], lambda k: self.refits.refitted_beyond(tried[k], tried[limits[k]], beaten), tried)
            self._do([*cases], lambda k: self.refits.refitted_beside(tried[k], tried[cases[k]], beaten), tried)
            self._ask_richer([k for k, c in tried.items() if c.fitted and k not in standing], tried)
        return _ordered(tried.values())

    def _ask_richer(self, places: Sequence[int], tried: dict[int, Candidate]) -> None:
        """Fit richer kinds of the best candidate to all windows where these show what the few windows did not."""
        best = max((k for k, c in tried.items() if c.final), key=lambda k: tried[k].gain.total, default=None)
        if best is None:
            return
        richer = [k for k in places if self._holds(k, best)]
        cases = self._special_cases(richer, [best])
        limits = [k for k in richer if k not in cases]
        self._do([*cases], lambda k: self.refits.refitted_beside(tried[k], tried[best]), tried)
        self._do(limits, lambda k: self.refits.refitted_if_promising(tried[k], tried[best]), tried)

    def _refit_alone(self, places: Sequence[int], tried: dict[int, Candidate]) -> float:
        """Fit candidates to all windows, the one with the best start first; the cost above which that one beats others.

        What it leaves tells which others are worth their end.
        """
        starts = self._side_by_side(places, lambda k: self.refits.begun(tried[k]))
        begun = dict(zip(places, starts, strict=True))
        first, *others = sorted(places, key=lambda k: begun[k].start.cost)
        threads = self.bench.threads
        self._do([first], lambda k: self.refits.refitted(tried[k], begun[k], threads=threads), tried)
        beaten = self.refits.beaten_by(tried[first])
        self._do(others, lambda k: self.refits.refitted(tried[k], begun[k], beaten), tried)
        return beaten

    def _do(self, items: Sequence[int], work: Callable[[int], Candidate], found: dict[int, Candidate]) -> None:
        found |= dict(zip(items, self._side_by_side(items, work), strict=True))

    def _special_cases(self, richer: Sequence[int], among: Sequence[int]) -> dict[int, int]:
        """Place of an effect's special case among some others, by the effect's place; only where there is one."""
        cases = {k: special_case(self.placed[k], [self.placed[j] for j in among]) for k in richer}
        return {k: among[place] for k, place in cases.items() if place is not None}

    def credited(self, found: tuple[Candidate, ...]) -> Ranking:
        """The ranking, with the base fitted anew from where the best candidate's fit ended, if that is better."""
        settings = self.bench.evidence
        credited = [c for c in found if c.final and supported(c.gain, len(c.effect.parameters), settings)]
        leader = min(credited, key=lambda c: c.fitted_model.fit.order, default=None)
        if leader is None:
            return Ranking(self.base, found)
        back_from = leader.fitted_model.fit
        best = min(self.base.fit, self.fits.without(leader), key=lambda fit: fit.order)
        if self.base.fit.cost - best.cost <= self.bench.negligible_share * best.cost:
            return Ranking(self.base, found, back_from)
        base = scored(self.bench, self.base.model, best, near=self.base.states)
        gains = (paired_gain(base.held_out, c.fitted_model.held_out, settings) if c.final else c.gain for c in found)
        return Ranking(base, _ordered(replace(c, gain=gain) for c, gain in zip(found, gains, strict=True)), back_from)

    def _ask_all_windows(self, promise: Array, looks: Sequence[FirstLook]) -> None:
        """Look at all windows if the few promise something, but so little that it may be chance."""
        if self.fits.whole or promise.max(initial=0.0) > self.bench.enough:
            return
        unsure = [int(k) for k in np.flatnonzero(promise >= self.bench.hope)]
        promise[unsure] = self._side_by_side(unsure, lambda k: self.fits.promise_of_all(self.placed[k], looks[k]))

    def _standing(self, tried: dict[int, Candidate]) -> list[int]:
        """Places of the best candidates and of all that the best one does not beat.

        A candidate whose fit gains less than is hoped for is out, whatever a linear step promised. Others stand as
        well, for few windows flatter the best one:

        1. Its special cases: a fit of hard friction ends early more often than one that softens it, so a richer effect
           may lead only because its fit went on.
        2. The best one of each smaller number of parameters: more of them bend to few windows more easily.
        """
        settings = self.bench.evidence
        order = sorted((k for k, c in tried.items() if self._gains(c)), key=lambda k: -tried[k].gain.total)
        if not order:
            return []
        standing: list[int] = []
        counts = {k: len(tried[k].effect.parameters) for k in order}
        leaner = {counts[k]: k for k in reversed(order) if counts[k] < counts[order[0]]}  # the best one comes last
        kept = {*leaner.values(), *(k for k in order if self._holds(order[0], k))}
        for k in sorted(order, key=counts.__getitem__):
            best = paired_gain(tried[k].fitted_model.held_out, tried[order[0]].fitted_model.held_out, settings)
            cases = [j for j in standing if self._special_cases([k], [j])]  # others may lead on few windows alone
            needless = any(self._needless(tried[k], tried[j]) for j in cases or standing)
            if not needless and (k in kept or not supported(best, 0, settings)):
                standing.append(k)
        return standing

    def _gains(self, candidate: Candidate) -> bool:
        """Whether a fit to few windows gains as much as a linear step must promise."""
        start = self.fits.start
        gained = candidate.fitted_model.fit.below(start)
        return candidate.fitted and self.bench.promise(gained, start) >= self.bench.hope

    def _holds(self, richer: int, poorer: int) -> bool:
        """Whether an effect is a special case of another one at its site, if only in the limit."""
        one, other = self.placed[richer], self.placed[poorer]
        return one.site == other.site and other.effect.name in one.effect.holds

    def _needless(self, candidate: Candidate, other: Candidate) -> bool:
        """Whether a candidate with more parameters than another one hardly explains more."""
        more = len(candidate.effect.parameters) - len(other.effect.parameters)
        if more <= 0:
            return False
        ours, theirs = candidate.fitted_model.fit, other.fitted_model.fit
        return self.bench.beside(other.fitted_model).promise(ours.below(theirs), theirs, more) < self.bench.hope

    def _side_by_side(self, items: Sequence[_In], work: Callable[[_In], _Out]) -> list[_Out]:
        return side_by_side(items, work, self.bench.threads, self.fits.stop)


def _ordered(candidates: Iterable[Candidate]) -> tuple[Candidate, ...]:
    return tuple(sorted(candidates, key=lambda c: (-c.gain.total, len(c.effect.parameters))))
