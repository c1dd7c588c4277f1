"""Which effects are the same to given logs: the equivalence class by which an answer is scored."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.benchmark.case import Case
from dr_lab.benchmark.observed import Compose, Observed, observe_exactly
from dr_lab.benchmark.outcome import BASE
from dr_lab.comparison.all_windows import on_all_windows
from dr_lab.comparison.calibrated import calibrate
from dr_lab.comparison.study import Study
from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.rank import rank
from dr_lab.effects.catalogue import candidates


class TruthClasses(ABC):
    """What finds out which effects given logs cannot tell from the truths."""

    def require(self, case: Case, compose: Compose) -> None:
        """Refuse a case whose classes cannot be found, before it is diagnosed; none is refused unless a rule says so.

        Raises:
            ConfigError: the rule does not apply to the case.
        """
        del case, compose

    @abstractmethod
    def of(
        self, case: Case, truths: Sequence[str], found: Sequence[Sequence[str]], observed: Observed, compose: Compose
    ) -> Mapping[str, Mapping[str, int]]:
        """Classes by truth, label → number of parameters; a truth that is not asked for is alone in its class.

        Args:
            case: what was diagnosed.
            truths: what is hidden, as ``effect@site``.
            found: what was answered.
            observed: the case as the diagnosis saw it.
            compose: gives the arguments of a verb.
        """


@dataclass(frozen=True)
class RankedClasses(TruthClasses):
    """Classes by the diagnosis' own ranking of noise-free logs, of truths that the answer does not hold exactly."""

    def of(
        self, case: Case, truths: Sequence[str], found: Sequence[Sequence[str]], observed: Observed, compose: Compose
    ) -> Mapping[str, Mapping[str, int]]:
        """Classes of the truths that the answer does not hold exactly."""
        single = case.kind == "single"
        unclear = [t for t in truths if (found != [[t]] if single else not any(t in group for group in found))]
        if not unclear:
            return {}
        exact = observe_exactly(case, compose, observed)
        return {t: equivalence_class(exact, t, tuple(other for other in truths if other != t)) for t in unclear}


def equivalence_class(observed: Observed, truth: str, others: tuple[str, ...]) -> dict[str, int]:
    """Candidates, the refitted base included, that explain noise-free logs as well as the truth does.

    Those whose Σ (residual/σ)² over all windows exceeds the truth's by less than the evidence threshold. The truth's
    own sum, which would be 0 if both engines solved the same equations without error, is the reference; it counts as 0
    where the truth is no candidate.

    Args:
        observed: noise-free logs, weighed by the noise of the real ones.
        truth: the effect that rivals are looked for.
        others: what else is hidden; it is added to the base first.

    Returns:
        Number of parameters by label, 0 for `BASE`; the truth is among them. Where the base is a member every effect
        is one, staying absent: then no other is listed.
    """
    study = observed.study
    base, threshold = calibrate(study), study.bench.evidence.threshold
    for label in others:
        base = next((_whole(study, base, each) for each in _ranked(observed, base, label)), base)
    own = next(iter(_ranked(observed, base, truth)), None)
    exact = None if own is None else _whole(study, base, own)
    count = 1 if own is None else len(own.effect.parameters)
    goal, most = (threshold, threshold) if exact is None else (threshold + exact.fit.cost, threshold + _sum(exact))
    if _sum(base) < most:
        return {truth: count, BASE: 0}
    rivals = [c for c in _ranked(observed, base) if c.fitted and c.effect.label != truth]
    alike = [c for c in rivals if _sum(_whole(study, base, c, goal)) < most]
    return {truth: count, **{c.effect.label: len(c.effect.parameters) for c in alike}}


def _ranked(observed: Observed, base: FittedModel, only: str | None = None) -> Sequence[Candidate]:
    """The candidates beside a base, or one alone, by label; none where it cannot be placed."""
    study = observed.study
    channels = study.bench.fit.channels
    placed = candidates(base.model, observed.effects, study.scales, study.compiled, channels).placed
    kept = [effect for effect in placed if only in (None, effect.label)]
    return rank(study.bench, base, kept, lambda _: None).candidates if kept else ()


def _whole(study: Study, base: FittedModel, candidate: Candidate, goal: float = np.inf) -> FittedModel:
    """A candidate on all windows: a ranking leaves those that it beats on a part of them as they were there."""
    done = candidate.final and candidate.fitted_model.fit.converged
    return candidate.fitted_model if done else on_all_windows(study, base, candidate, goal)


def _sum(fitted_model: FittedModel) -> float:
    return float(np.sum(fitted_model.held_out.window_sum) + np.sum(fitted_model.fit.residuals**2))
