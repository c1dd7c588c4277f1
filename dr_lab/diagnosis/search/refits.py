"""Fits of the candidates to all windows, where they stand on few of them."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.slopes import Slopes
from dr_lab.diagnosis.search.as_special_case import in_the_limit, reaching
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.candidate_fits import CandidateFits
from dr_lab.diagnosis.search.screen import linear_gain
from dr_lab.effects.effect import PlacedEffect
from dr_lab.trajectory import Array


class Begun(NamedTuple):
    """Where a fit to all windows begins.

    Attributes:
        start: the context and states there.
        slopes: by the states and maybe by the first parameters.
    """

    start: Point
    slopes: Slopes


class Refits:
    """How candidates are fitted to all windows, each on as many `threads` as its fit is given.

    Args:
        fits: of the candidates to a part of the windows.
    """

    def __init__(self, fits: CandidateFits) -> None:
        self._fits, self._bench, self._base = fits, fits.bench, fits.base

    def beaten_by(self, candidate: Candidate) -> float:
        """Cost on all windows above which a candidate beats others without a doubt; ∞ if it has no fit there."""
        return self._bench.cost_at(candidate.fitted_model.fit, self._bench.enough) if candidate.final else np.inf

    def begun(self, candidate: Candidate, threads: int = 1) -> Begun:
        """Where a candidate's fit to all windows begins: where that to few windows ended, with the states fitted.

        What the few windows left absent may act in others, as the second of two end stops does; so it also begins where
        the effect's further starts have that, if this is better. Few windows bend the inertia of free bodies to what
        is left in them; so it also begins with the base's.

        An effect that acts at once and promises little begins at absent, where the base's slopes are known. So does one
        that would begin worse than that: in the other windows the base's states may be far off beside what the few
        found, as where the base is tilted.
        """
        effect, base, space = candidate.effect, self._base.fit, self._base.model.space
        fitter = self._fits.fitter(self._bench, effect, threads)
        if effect.starts:
            return self._settled(fitter, candidate)
        absent = self._absent(fitter, effect)
        there = Begun(Point(absent.z, absent.delta, absent.residuals, absent.cost, absent.infeasible), base.slopes)
        if self._bench.promise(linear_gain(fitter, absent, base, space), base) < self._bench.enough:
            return there
        return min(there, self._settled(fitter, candidate), key=lambda each: each.start.order)

    def _settled(self, fitter: Fitter, candidate: Candidate) -> Begun:
        return Begun(*fitter.settled(*(self._there(fitter, candidate, z) for z in self._ends(fitter, candidate))))

    def refitted(self, candidate: Candidate, begun: Begun, beaten: float = np.inf, threads: int = 1) -> Candidate:
        """A candidate fitted to all windows, or left absent if it does not gain enough there.

        One that is foretold to stay above a cost at which it is `beaten` is left as it is.
        """
        effect, hoped = candidate.effect, self._bench.hoped(self._base.fit)
        fitter, goal = self._fits.fitter(self._bench, effect, threads), min(hoped, beaten)
        again = fitter.run(begun.start.z, begun.start.delta, begun.slopes, goal=goal)
        if again.cost <= goal:
            return self._fits.candidate(effect, again, candidate.identifiability, candidate.predicted, threads)
        if beaten < hoped:
            return candidate
        absent = replace(self._absent(fitter, effect), slopes=self._base.fit.slopes)  # to save memory
        return self._fits.at_absent(effect, absent, candidate.identifiability, candidate.predicted)

    def refitted_beyond(
        self, candidate: Candidate, limit: Candidate, beaten: float = np.inf, threads: int = 1
    ) -> Candidate:
        """The same for an effect of which a standing one is the limit, where its fit begins if it may gain from there.

        On few windows it may lead because its fit went on farther. It begins where that ended only if this is better by
        enough to matter. One that is foretold to stay above is left.
        """
        if not limit.final:
            return self.refitted(candidate, self.begun(candidate, threads), beaten, threads)
        effect, poorer = reaching(candidate.effect, limit.effect), limit.fitted_model
        fitter = self._fits.fitter(self._bench, effect, threads)
        goal = min(self._bench.cost_at(poorer.fit, 0.0), beaten)
        there, gain = self._in_the_limit(fitter, effect, candidate, limit)
        end, below = self._own_end(fitter, candidate), self._bench.beside(poorer).hoped(poorer.fit)
        again = fitter.rerun_below(end, there, below, goal) if gain > 0 else fitter.rerun(end, goal=goal)
        if again.cost > goal:
            return candidate
        return self._fits.candidate(effect, again, candidate.identifiability, candidate.predicted, threads)

    def refitted_if_promising(self, candidate: Candidate, limit: Candidate, threads: int = 1) -> Candidate:
        """The same where a linear step from the limit promises enough; an effect that promises too little is left."""
        effect, base = reaching(candidate.effect, limit.effect), limit.fitted_model.fit
        _, gain = self._in_the_limit(self._fits.fitter(self._bench, effect, threads), effect, candidate, limit)
        beside, extra = self._bench.beside(limit.fitted_model), len(effect.parameters) - len(limit.effect.parameters)
        if beside.promise(gain, base, extra) < beside.hope:
            return candidate
        return self.refitted_beyond(candidate, limit, beside.hoped(base), threads)

    def _in_the_limit(
        self, fitter: Fitter, effect: PlacedEffect, candidate: Candidate, limit: Candidate
    ) -> tuple[Fit, float]:
        """An effect linearised where it acts as its limit is fitted, and by how much that step could lower the cost."""
        poorer = limit.fitted_model
        z = in_the_limit(effect, limit.effect, fitter.space, candidate.fitted_model.values(), poorer.values())
        slopes = poorer.fit.slopes
        known = Slopes(slopes.state, slopes.parameter[..., : len(self._base.fit.z)])
        (there,) = fitter.outlooks(z[None], poorer.fit.delta, known)
        lost = (there.infeasible & ~poorer.fit.infeasible).any()
        return there, 0.0 if lost else linear_gain(fitter, there, poorer.fit, poorer.model.space)

    def refitted_beside(
        self, candidate: Candidate, poorer: Candidate, beaten: float = np.inf, threads: int = 1
    ) -> Candidate:
        """The same for an effect whose special case stands, if a linear step from there promises enough.

        The fit begins there, or where that to few windows ended if this gains enough at once. One that gains too little
        is left.
        """
        if not poorer.final:
            return self.refitted(candidate, self.begun(candidate, threads), beaten, threads)
        effect = reaching(candidate.effect, poorer.effect)
        further = self._fits.further(self._bench, effect, poorer)
        if further is None:
            return self.refitted_beyond(candidate, poorer, beaten, threads)
        there, more = further
        if not more:
            return candidate
        fitter, beside = self._fits.fitter(self._bench, effect, threads), self._bench.beside(poorer.fitted_model)
        below = beside.hoped(poorer.fitted_model.fit)
        goal = min(below, beaten)
        again = fitter.rerun_below(self._own_end(fitter, candidate), there, below, goal)
        if again.cost > goal:
            return candidate
        return self._fits.candidate(effect, again, candidate.identifiability, candidate.predicted, threads)

    def _ends(self, fitter: Fitter, candidate: Candidate) -> Array:
        """Where the fit to few windows ended, and variants of it that may be better on all, (c, n)."""
        space, z, base = fitter.space, candidate.fitted_model.fit.z, self._base
        ends, own = [z], {p.name for p in candidate.effect.parameters}
        for start in candidate.effect.starts:
            absent = {name for name in own & set(start) if z[space.index(name)] == space.nominal[space.index(name)]}
            ends.append(z.copy())
            for name in (name for name in start if absent and (name in absent or name not in own)):
                ends[-1][space.index(name)] = start[name]
        if base.model.inertials:
            ends.append(np.append(base.fit.z, z[len(base.fit.z) :]))
        return np.unique(np.stack(ends), axis=0)

    def _own_end(self, fitter: Fitter, candidate: Candidate) -> Point:
        """All windows where the fit to few of them ended."""
        return self._there(fitter, candidate, candidate.fitted_model.fit.z)

    def _there(self, fitter: Fitter, candidate: Candidate, z: Array) -> Point:
        """All windows at a context, with the states that the fit to few of them ended with."""
        delta = self._base.fit.delta.copy()
        delta[self._bench.screened(self._base.fit)] = candidate.fitted_model.fit.delta
        return fitter.begin(z, delta)

    def _absent(self, fitter: Fitter, effect: PlacedEffect) -> Fit:
        """An effect linearised at absent on all windows."""
        base = self._base.fit
        nominal = np.append(base.z, [p.nominal for p in effect.parameters])
        return fitter.outlooks(nominal[None], base.delta, base.slopes, base)[0]
