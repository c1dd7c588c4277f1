"""A model fitted to the logs and what the report says of it."""

from dataclasses import dataclass, replace

from dr_lab.comparison import entries
from dr_lab.comparison.localised import predicted_score
from dr_lab.comparison.study import Study
from dr_lab.diagnosis.evidence.bench import FittedModel, fit_and_score, fitted_for_comparison, fitted_to_the_end
from dr_lab.diagnosis.evidence.score import Score, score_of
from dr_lab.physics.context import ContextEstimate
from dr_lab.reports.gap_entries import ParameterEntry, RungEntry


@dataclass(frozen=True)
class Described:
    """A fitted model with its entry in the ladder.

    Attributes:
        fitted_model: the fitted and scored model.
        estimate: mean and covariance of its context.
        rung: its entry in the report's ladder.
    """

    fitted_model: FittedModel
    estimate: ContextEstimate
    rung: RungEntry


def calibrate(study: Study) -> FittedModel:
    """Fit the model as given, no effect added."""
    return fitted_to_the_end(study.bench, _fitted(study))


def calibrated(study: Study) -> FittedModel:
    """`calibrate` where the model is only what others are compared with, which takes less where bodies are free."""
    return fitted_for_comparison(study.bench, _fitted(study))


def _fitted(study: Study) -> FittedModel:
    return fit_and_score(study.bench, study.model, study.model.space.nominal)


def describe(study: Study, fitted_model: FittedModel) -> Described:
    """Uncertainties and predicted score of a fitted model."""
    estimate, table = entries.parameters(study, fitted_model)
    predicted = predicted_score(study, fitted_model.model, fitted_model.fit.z)
    labels = [effect.label for effect in fitted_model.model.effects]
    rung = entries.rung(labels, fitted_model.held_out, predicted, table)
    return Described(fitted_model, estimate, replace(rung, fit=entries.fitted(fitted_model.fit)))


def as_given(study: Study) -> tuple[Score, RungEntry]:
    """Held-out score and ladder-like entry of the model before any fit."""
    z, bench = study.model.space.nominal, study.bench
    refitted = score_of(*study.fits(study.model, z, bench.held_out))
    nominal = {p.name: ParameterEntry(p.nominal, None, p.unit) for p in study.model.space.parameters}
    labels = [effect.label for effect in study.model.effects]
    return refitted, entries.rung(labels, refitted, predicted_score(study, study.model, z), nominal)
