"""Where and over which horizon a model at a context fails: the entries `where`, `horizons` and `input_correlation`."""

from dataclasses import replace
from typing import Any

from dr_lab.diagnosis.discrepancy import horizon_error, input_correlations
from dr_lab.diagnosis.localise import localise
from dr_lab.diagnosis.score import Score, score_of
from dr_lab.diagnosis.states import fit_states
from dr_lab.diagnosis.windows import cut
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array
from dr_lab.workflows import entries
from dr_lab.workflows.study import Study


def predicted_score(study: Study, model: Model, z: Array) -> Score:
    """Score on held-out windows whose start is known only from earlier samples."""
    return score_of(*fit_states(model, z, study.predicted, study.bench.solver, study.bench.threads))


def failure(study: Study, model: Model, z: Array) -> dict[str, Any]:
    """Report entries on where the model fails on the held-out logs, or the fit logs where none is held out."""
    bench, prediction, settings = study.bench, study.prediction, study.local
    replay, fit = fit_states(model, z, study.predicted, bench.solver, bench.threads)
    error = horizon_error(replay, fit, prediction.run_in, prediction.margin, settings.horizons)
    correlations = input_correlations(replay, fit, replay.commands, settings.lags)
    short = replace(prediction, length=settings.length, stride=settings.length, max_windows=settings.max_windows)
    logs = study.measurements.held_out or study.measurements.fit
    local = cut(logs, study.measurements, study.compiled, short)
    regions = localise(*fit_states(model, z, local, bench.solver, bench.threads), settings)
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
