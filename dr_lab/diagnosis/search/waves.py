"""Fits of the candidates beside one model to few windows, wave by wave: what promises most goes first."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from dr_lab.diagnosis.search.as_special_case import holds, limits, special_cases, taking_over
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.candidate_fits import CandidateFits
from dr_lab.diagnosis.search.periods import with_periods
from dr_lab.diagnosis.search.shortlist import shortlist
from dr_lab.effects.effect import PlacedEffect
from dr_lab.trajectory import Array


class Waves:
    """All candidates linearised, and fits of those that promise enough.

    Args:
        fits: of the candidates to a part of the windows.
        placed: the candidates.
        done: is told each label.

    Attributes:
        placed: the candidates; those whose law is periodic have the periods that the residuals show, those that hold an
            effect of the base begin in its place.
    """

    def __init__(self, fits: CandidateFits, placed: Sequence[PlacedEffect], done: Callable[[str], None]) -> None:
        self._fits, self._bench, self._done = fits, fits.bench, done
        model, values = fits.base.model, fits.base.values()
        begun = [taking_over(effect, model, values) for effect in placed]
        self.placed = with_periods(fits.thin, model, fits.start, begun)
        self._looks = fits.side_by_side(self.placed, fits.look)
        promise = self._promises()
        order = np.argsort(-promise, kind="stable")
        self._waiting = [int(k) for k in order if promise[k] >= self._bench.hope]
        self._hopeful = tuple(self._waiting)
        self._reached = 0.0  # the largest gain of a fit

    def first(self) -> dict[int, Candidate]:
        """The candidates, by place, that are fitted and scored at first: see `rank`, rule 2."""
        settings, found = self._bench.evidence, dict[int, Candidate]()
        reachable = max((self._looks[k].gain for k in self._waiting), default=0.0)
        for _ in range(2):
            self._fit(self._chosen(settings.least_promise * reachable, settings.most_fits - len(found)), found)
            reachable = self._reached
        self._fit(self._with_cases(self._typical((settings.most_fits + 1) // 2)), found)
        self._fit(self._crowded_out(found), found)
        self._fit(self._chosen(self._reached, settings.most_fits), found)
        self._widen(found)
        return found

    def next(self) -> dict[int, Candidate]:
        """As many others, and those near the best of them: what promises most in typical windows.

        Those before may have met wild ones alone.
        """
        found: dict[int, Candidate] = {}
        self._waiting.sort(key=lambda k: -self._looks[k].evidence)
        self._fit(self._chosen(0.0, self._bench.evidence.most_fits), found)
        self._fit(self._crowded_out(found), found)
        self._widen(found)
        return found

    def unfitted(self, found: dict[int, Candidate]) -> dict[int, Candidate]:
        """The candidates that are none of those found."""
        left = [k for k in range(len(self.placed)) if k not in found]
        return {k: self._told(self._fits.unfitted(self.placed[k], self._looks[k])) for k in left}

    def _promises(self) -> Array:
        """Evidence that each promises, on all windows if the few promise something, but so little that it is chance."""
        fits, start = self._fits, self._fits.start
        promise = np.array([self._bench.promise(each.gain, start) for each in self._looks])
        if fits.whole or promise.max(initial=0.0) > self._bench.enough:
            return promise
        unsure = [int(k) for k in np.flatnonzero(promise >= self._bench.hope)]
        promise[unsure] = fits.side_by_side(unsure, lambda k: fits.promise_of_all(self.placed[k], self._looks[k]))
        return promise

    def _chosen(self, least: float, most: int) -> list[int]:
        """At most so many that wait and promise so much, and special cases of theirs."""
        return self._with_cases(
            shortlist([k for k in self._waiting if self._looks[k].gain >= least], self.placed, max(most, 0))
        )

    def _typical(self, most: int) -> list[int]:
        """Those that still wait of so many that promise most in typical windows; a few wild ones may hide them."""
        leading = sorted(self._hopeful, key=lambda k: -self._looks[k].evidence)[:most]
        return [k for k in leading if k in self._waiting]

    def _with_cases(self, wave: list[int]) -> list[int]:
        """Some that wait, and their special cases that wait."""
        cases = (j for k in wave for j in self._waiting if holds(self.placed[k], self.placed[j]))
        return list(dict.fromkeys([*wave, *cases]))

    def _crowded_out(self, found: dict[int, Candidate]) -> list[int]:
        """Effects that wait at the site of the best fitted one and are near it, or near another there like it.

        They hold one, or what it holds, as a special case, or they say that they are confused with that. Alike are
        those that gain `least_named` of what the best one does: which of them leads, few windows hardly tell. Besides,
        what the best one, or the simplest that is like it, says that it is confused with: there, or where it promises
        most if it cannot sit there.
        """
        best = max(found, key=lambda k: found[k].gain.total, default=None)
        if best is None:
            return []
        site, least = self.placed[best].site, self._bench.evidence.least_named * self._gained(found[best])
        alike = [k for k in found if self.placed[k].site == site and self._gained(found[k]) >= least]
        poorer = {name for k in alike for name in (self.placed[k].effect.name, *self.placed[k].effect.holds)}
        others = [k for k in self._waiting if self.placed[k].site == site]
        near = {k: {*self.placed[k].effect.holds, *self.placed[k].effect.confused_with} for k in others}
        crowded = [k for k in others if poorer & near[k]]
        simplest = min(alike, key=lambda k: (len(self.placed[k].parameters), -found[k].gain.total))
        confused = (j for k in (best, simplest) for j in self._confused_with(self.placed[k]))
        return list(dict.fromkeys([*crowded, *confused]))

    def _confused_with(self, best: PlacedEffect) -> Iterator[int]:
        """What waits and may pass for an effect, as that says: a load's body is no site of the motor that lifts it."""
        for name in best.effect.confused_with:
            sites = [k for k, each in enumerate(self.placed) if each.effect.name == name]
            here = [k for k in sites if self.placed[k].site == best.site]
            waiting = [k for k in here or sites if k in self._waiting]
            yield from sorted(waiting, key=lambda k: -self._looks[k].gain)[:1]

    def _fit(self, wave: list[int], found: dict[int, Candidate]) -> None:
        """Fit some candidates. An effect waits for its special case, to which it may add nothing, or for its limit."""
        wave.sort(key=lambda k: -len(self.placed[k].parameters))  # those that take longest begin
        cases = special_cases(self.placed, wave, sorted({*wave, *found}))
        fits, placed, looks = self._fits, self.placed, self._looks
        alone = [k for k in wave if k not in cases]
        plain = limits(placed, alone, sorted({*alone, *found}))
        alone.sort(key=lambda k: len(placed[k].parameters) if k in plain else 0)  # a limit comes before what has it
        if alone and not found:  # what the most promising one leaves tells which others are worth their end
            first = max(alone, key=lambda k: looks[k].gain)
            first = plain.get(first, first)
            threads = self._bench.threads
            found |= fits.of([first], lambda k: self._told(fits.fitted(placed[k], looks[k], threads=threads)))
            alone.remove(first)
        goal, known = fits.goal(list(found.values())), dict(found)

        def fitted(k: int, case: Candidate | None) -> Candidate:
            if k in plain:
                return self._told(fits.fitted(placed[k], looks[k], goal, limit=case or known[plain[k]]))
            if k not in cases:
                return self._told(fits.fitted(placed[k], looks[k], goal))
            return self._told(fits.fitted_beside(placed[k], looks[k], case or known[cases[k]]))

        found |= fits.behind([*alone, *cases], {**plain, **cases}, fitted)
        self._waiting = [k for k in self._waiting if k not in found]
        self._reached = max([self._reached, *map(self._gained, found.values())])

    def _widen(self, found: dict[int, Candidate]) -> None:
        """Go on with the fits that ran into a bound which is no physics, where they gain enough to matter.

        Or where a linear step, which knows how far the bound may be moved, promised so much: of a lag of 0.2 s the
        first 12 ms gain next to nothing.
        """
        settings, waiting = self._bench.evidence, list(found)
        for _ in range(settings.widenings):
            least = settings.least_promise * self._reached
            waiting = [k for k in waiting if max(self._gained(found[k]), self._looks[k].gain) >= least]
            farther = self._fits.side_by_side([found[k] for k in waiting], self._fits.farther)
            moved = {k: candidate for k, candidate in zip(waiting, farther, strict=True) if candidate is not None}
            found |= moved
            self._reached = max([self._reached, *map(self._gained, moved.values())])
            waiting = list(moved)

    def _gained(self, candidate: Candidate) -> float:
        return candidate.fitted_model.fit.below(self._fits.start)

    def _told(self, candidate: Candidate) -> Candidate:
        self._done(candidate.effect.label)
        return candidate
