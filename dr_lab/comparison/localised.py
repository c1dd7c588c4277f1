"""Where and over which horizon a model at a context fails: the entries `where`, `horizons` and `input_correlation`."""

from typing import Any

from dr_lab.comparison import entries
from dr_lab.comparison.study import Study
from dr_lab.diagnosis.discrepancy import horizon_error, input_correlations
from dr_lab.diagnosis.evidence.score import Score, score_of
from dr_lab.diagnosis.localise import localise
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array


def predicted_score(study: Study, model: Model, z: Array) -> Score:
    """Score on held-out windows whose start is known only from earlier samples."""
    return score_of(*study.fits(model, z, study.predicted))


def failure(study: Study, model: Model, z: Array) -> dict[str, Any]:
    """Report entries on where the model fails on the held-out logs, or the fit logs where none is held out."""
    prediction, settings = study.settings.predicted, study.settings.localise
    replay, fit = study.fits(model, z, study.predicted)
    error = horizon_error(replay, fit, prediction.run_in, prediction.margin, settings.horizons)
    correlations = input_correlations(replay, fit, replay.commands, settings.lags)
    regions = localise(*study.fits(model, z, study.short, rough=True), settings)
    return {
        "where": entries.where(regions),
        "horizons": entries.horizons(error),
        "input_correlation": [
            {
                "signal": c.signal,
                "command": c.command,
                "peak_lag": c.peak[0],
                "peak": c.peak[1],
                "band": c.band,
                "significant": abs(c.peak[1]) > c.band,
            }
            for c in correlations
        ],
    }
