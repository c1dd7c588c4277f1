"""Ladders that lack one of their effects, each fitted as well as it can be, and what a ranking fitted beside one."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, scored
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.restack import stacked
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.diagnosis.search.taken_away import taken_away
from dr_lab.physics.model_effect import ModelEffect

_Fewer = tuple[tuple[AddedEffect, ...], FittedModel]


@dataclass(frozen=True, eq=False)
class _Asked:
    """What is asked of a ladder."""

    base: FittedModel
    steps: tuple[AddedEffect, ...]
    place: int
    goal: float

    def same(self, other: "_Asked") -> bool:
        """Whether the other asks the same of the same objects."""
        ours, theirs = (self.base, *self.steps), (other.base, *other.steps)
        alike = len(ours) == len(theirs) and all(a is b for a, b in zip(ours, theirs, strict=True))
        return alike and (self.place, self.goal) == (other.place, other.goal)


class Deletions:
    """Fits ladders without one of their effects and remembers them by base and steps, told apart as objects.

    A ladder's effects are judged after a rung and again when the climb is over.

    Args:
        bench: data and settings.
    """

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        self._known: list[tuple[_Asked, _Fewer]] = []
        self._tried: list[Fit] = []
        self._ranked: dict[tuple[str, ...], FittedModel] = {}

    def tried(self, fit: Fit) -> None:
        """Take it as known that from this fit's end, without its last effect, no better fit of the others is reached.

        The ladder that the effect was added to is that best fit, then.
        """
        self._tried.append(fit)

    def ranked(self, candidates: Iterable[Candidate]) -> None:
        """Remember the newest ranking's models that are fitted to all windows."""
        self._ranked = {labels(c.fitted_model.model.effects): c.fitted_model for c in candidates if c.final}

    def as_ranked(self, effects: Sequence[ModelEffect]) -> FittedModel | None:
        """The model with these effects as the newest ranking fitted it; None where it did not."""
        return self._ranked.get(labels(effects))

    def without(
        self, base: FittedModel, steps: tuple[AddedEffect, ...], place: int, goal: float = np.inf
    ) -> tuple[tuple[AddedEffect, ...], FittedModel]:
        """The steps without one of them, and their base; the last model is also fitted from `taken_away`'s starts.

        Args:
            base: the calibrated model.
            steps: what was added.
            place: of the step that goes.
            goal: a cost; see `Fitter.run`.
        """
        asked = _Asked(base, steps, place, goal)
        for known, answer in self._known:
            if asked.same(known):
                return answer
        fewer = stacked(self.bench, base, steps[:place], steps[place + 1 :], goal)
        whole = steps[-1].fitted_model
        last = place == len(steps) - 1 and any(whole.fit is fit for fit in self._tried)
        found = (fewer, base) if last else self._as_good_as_it_can(base, fewer, whole, goal)
        self._known.append((asked, found))
        return found

    def _as_good_as_it_can(
        self, base: FittedModel, fewer: tuple[AddedEffect, ...], whole: FittedModel, goal: float
    ) -> _Fewer:
        """Steps that lack one effect; the last model also fitted from where the whole ladder's ended."""
        last = fewer[-1].fitted_model if fewer else base
        wanted = goal if last.fit.infeasible.any() else min(goal, last.fit.cost)
        fitter = Fitter(Replay(last.model, self.bench.fit, self.bench.threads), self.bench.solver)
        again = fitter.rerun(*taken_away(fitter, whole), goal=wanted)
        if again.order >= last.fit.order:
            return fewer, base
        better = scored(self.bench, last.model, again)
        return ((*fewer[:-1], replace(fewer[-1], fitted_model=better)), base) if fewer else (fewer, better)


def labels(effects: Sequence[ModelEffect]) -> tuple[str, ...]:
    """Labels of effects, in their order: models with the same ones differ in their fits alone."""
    return tuple(effect.label for effect in effects)
