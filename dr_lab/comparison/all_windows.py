"""A candidate fitted to all windows, whatever few of them promised."""

import numpy as np

from dr_lab.comparison.study import Study
from dr_lab.diagnosis.evidence.bench import FittedModel, fitted
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.candidate_fits import CandidateFits


def on_all_windows(study: Study, base: FittedModel, candidate: Candidate, goal: float = np.inf) -> FittedModel:
    """A candidate fitted from where it ended and from its starts, and beyond bounds that it meets.

    Args:
        study: model and logs.
        base: the model without it.
        candidate: ranked beside the base.
        goal: a cost; a fit that is foretold to stay above it ends early (`Fitter.run`), and within its bounds.
    """
    bench, model, values = study.bench.beside(base), candidate.fitted_model.model, candidate.fitted_model.values()
    starts = [model.space.vector({**values, **start}) for start in ({}, *candidate.effect.starts)]
    fits = [fitted(bench, model, start, goal=goal) for start in starts]
    beside, best = CandidateFits(bench, base), min(fits, key=lambda fit: fit.order)
    found = beside.candidate(candidate.effect, best, candidate.identifiability, candidate.predicted, bench.threads)
    for _ in range(bench.evidence.widenings if best.cost <= goal else 0):
        moved = beside.farther(found, bench.threads)
        if moved is None:
            break
        found = moved
    return found.fitted_model
