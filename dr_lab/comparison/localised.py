"""Where and over which horizon a model at a context fails: the entries `where`, `horizons` and `input_correlation`."""

from dr_lab.comparison.study import Study
from dr_lab.diagnosis.discrepancy import HorizonError, horizon_error, input_correlations
from dr_lab.diagnosis.evidence.noise_floor import at_floor, channel_at_floor
from dr_lab.diagnosis.evidence.score import Score, score_of
from dr_lab.diagnosis.localise import localise
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.physics.model import Model
from dr_lab.reports.gap import Failure
from dr_lab.reports.gap_entries import CorrelationEntry, HorizonEntry, RegionEntry
from dr_lab.trajectory import Array


def predicted_score(study: Study, model: Model, z: Array) -> Score:
    """Score on held-out windows whose start is known only from earlier samples."""
    return score_of(*study.fits(model, z, study.predicted))


def failure(study: Study, model: Model, z: Array, held_out: Score) -> Failure:
    """Where the model fails on the held-out logs, or the fit logs where none is held out.

    Args:
        study: model and logs.
        model: the one that may fail.
        z: its context, shape (n,).
        held_out: its score there; channels of which it leaves noise alone fail nowhere.
    """
    prediction, settings = study.settings.predicted, study.settings.localise
    replay, fit = study.fits(model, z, study.predicted)
    error = horizon_error(replay, fit, prediction.run_in, prediction.margin, settings.horizons)
    correlations = input_correlations(replay, fit, replay.commands, settings.lags)
    short, states, tape = study.fits.rough(model, z, study.short)
    failing = _failing(held_out, study.bench.evidence)
    regions = [region for region in localise(short, states, settings, tape) if region.signal in failing]
    return Failure(
        where=tuple(RegionEntry(r.signal, r.region, r.share, r.samples, r.chi2) for r in regions),
        horizons=_horizons(error),
        input_correlation=tuple(
            CorrelationEntry(c.signal, c.command, *c.peak, c.band, abs(c.peak[1]) > c.band) for c in correlations
        ),
    )


def _failing(score: Score, evidence: EvidenceSettings) -> frozenset[str]:
    """The channels of which a model leaves more than noise."""
    if at_floor(score, evidence):
        return frozenset()
    return frozenset(name for name, each in score.channels.items() if not channel_at_floor(each, evidence))


def _horizons(error: HorizonError) -> tuple[HorizonEntry, ...]:
    """Error against the time predicted open loop."""
    return tuple(
        HorizonEntry(float(edge), {name: float(values[i]) for name, values in error.rmse.items()})
        for i, edge in enumerate(error.horizon)
    )
