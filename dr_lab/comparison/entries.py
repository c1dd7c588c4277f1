"""Entries of `report.json` (schema dr_lab/gap/1) made from what the diagnosis found."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from dr_lab.comparison.notes import study_notes
from dr_lab.comparison.study import Study
from dr_lab.diagnosis.evidence.bench import Bench, FittedModel
from dr_lab.diagnosis.evidence.confirmation import Confirmation
from dr_lab.diagnosis.evidence.noise_floor import at_floor, beyond_white
from dr_lab.diagnosis.evidence.score import Score
from dr_lab.diagnosis.evidence.trade import trades
from dr_lab.diagnosis.fit import trust
from dr_lab.diagnosis.fit.covariance import estimate, per_log
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.law_check import LawCheck
from dr_lab.diagnosis.search.uncertainty import known
from dr_lab.diagnosis.search.verdict import Verdict
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.physics.context import ContextEstimate
from dr_lab.physics.parameter import Parameter
from dr_lab.reports.gap import SCHEMA, GapReport
from dr_lab.reports.gap_entries import (
    CandidateEntry,
    ConfirmationEntry,
    ConfirmingGainEntry,
    ErrorsEntry,
    FitEntry,
    LawEntry,
    LogScatterEntry,
    LogsEntry,
    NoiseEntry,
    ParameterEntry,
    Parameters,
    RemainingEntry,
    RungEntry,
    WindowsEntry,
)
from dr_lab.reports.quantity import in_unit, number, telling_apart
from dr_lab.trajectory import Array


def begun(verb: str, study: Study, ladder: Sequence[RungEntry], last: Score) -> GapReport:
    """What every report starts with: names, noise and numerical floors, notes on the data, clocks, models.

    Args:
        verb: its name.
        study: model and logs.
        ladder: the models.
        last: what the last of them leaves.
    """
    measured = study.measurements
    noise = {
        name: NoiseEntry(noise.std, noise.unit, noise.source, study.floor.error.get(name))
        for name, noise in measured.noise.items()
    }
    logs = LogsEntry(tuple(log.name for log in measured.fit), tuple(log.name for log in measured.held_out))
    return GapReport(
        schema=SCHEMA,
        verb=verb,
        model=study.model.name,
        measurements=measured.name,
        noise=noise,
        logs=logs,
        windows=_windows(study),
        clocks={log.name: log.clocks for log in (*measured.fit, *measured.held_out) if log.clocks},
        notes=tuple(study_notes(study)),
        verdict=None,
        ladder=tuple(ladder),
        remaining=remaining(last, study.bench.evidence),
        run="",
    )


def _windows(study: Study) -> WindowsEntry:
    """How long and how many windows are."""
    bench = study.bench
    confirm = 0 if bench.confirms is None else len(bench.confirms)
    return WindowsEntry(study.settings.windows.length, len(bench.fit), len(bench.held_out), confirm)


def rung(labels: Sequence[str], refitted: Score, predicted: Score, parameters: Parameters) -> RungEntry:
    """One model of the ladder."""
    errors = ErrorsEntry(
        chi2=refitted.chi2,
        degrees_of_freedom=refitted.freedom,
        rmse=refitted.rmse,
        nrmse=refitted.nrmse,
        fit_percent=refitted.fit_percent,
        chi2_predicted=predicted.chi2,
        rmse_predicted=predicted.rmse,
        infeasible_windows=max(refitted.infeasible, predicted.infeasible),
    )
    return RungEntry(tuple(labels), errors, parameters)


def fitted(fit: Fit) -> FitEntry:
    """How a fit ended, and how many of its windows diverge and took no part in it."""
    return FitEntry(fit.converged, fit.iterations, len(fit.infeasible), int(fit.infeasible.sum()))


def parameters(study: Study, fitted_model: FittedModel) -> tuple[ContextEstimate, Parameters]:
    """Estimate of a fitted context and its table, with the scatter between logs in percent (CV)."""
    space, bench = fitted_model.model.space, study.bench
    found, by_step = known(bench, fitted_model)
    logs = per_log(space, fitted_model.fit, bench.fit)
    doubted = trust.doubts(found, fitted_model.fit, bench.fit, bench.evidence)
    scatters = [
        LogScatterEntry(
            cv_percent=_cv_percent(space.parameters[column], logs[:, column], float(found.mean[column]), std),
            per_log=dict(zip(bench.fit.logs, logs[:, column].tolist(), strict=True)),
            doubts=tuple(doubted[name]),
            bounds=(float(space.low[column]), float(space.high[column])),
            std_by_step=float(by_step[column]),
        )
        for column, (name, std) in enumerate(zip(space.names, found.std.tolist(), strict=True))
    ]
    marked = _marked(found).items()
    return found, {name: replace(row, scatter=each) for (name, row), each in zip(marked, scatters, strict=True)}


def ranking(study: Study, found: Sequence[Candidate], verdict: Verdict) -> tuple[CandidateEntry, ...]:
    """Candidates in the verdict's order; `gain` is the share of a typical window's χ² that an effect removes.

    Of a candidate that was tried on a part of the fitted windows alone, and beaten there, all figures are from these.
    """
    order = {label: place for place, label in enumerate(verdict.effects)}
    ordered = sorted(found, key=lambda c: order.get(c.effect.label, len(order)))
    return tuple(_candidate(study, candidate, verdict) for candidate in ordered)


def _candidate(study: Study, candidate: Candidate, verdict: Verdict) -> CandidateEntry:
    label, gain, share = candidate.effect.label, candidate.gain, study.bench.evidence.replacement_share
    return CandidateEntry(
        effect=candidate.effect.effect.name,
        site=candidate.effect.site,
        held_out_chi2=candidate.fitted_model.held_out.chi2 if candidate.final or not candidate.fitted else None,
        gain=gain.share,
        gain_ci=(gain.low, gain.high),
        evidence=gain.total,
        evidence_low=gain.total_low,
        wins=gain.wins,
        fitted=candidate.fitted,
        final=candidate.final,
        gap_closed=dict(gain.channels),
        predicted_gain=candidate.predicted,
        status=verdict.status[label],
        absorbed_by_parameters=label in verdict.absorbed,
        replaced_by=_replaced_by(candidate, share) if label in verdict.absorbed else {},
        excitation=candidate.identifiability.alone**0.5,
        parameters=_own(candidate, study),
    )


def _replaced_by(candidate: Candidate, told: float) -> dict[str, float]:
    """Parameters that take the effect's place, in widths of their bounds for a full width of the effect."""
    moves = candidate.identifiability.replacement
    names, largest = candidate.fitted_model.model.space.names, float(np.abs(moves).max(initial=0.0))
    order = np.argsort(-np.abs(moves))
    return {names[k]: float(moves[k]) for k in order if abs(moves[k]) >= told * largest}


def confirmation(found: Confirmation | None) -> ConfirmationEntry | None:
    """What the windows that chose nothing say; None where nothing was added."""
    if found is None:
        return None
    if found.apart is None:
        return ConfirmationEntry(found.status, found.predicted_worse, 0)
    apart, gain = found.apart, found.apart.gain
    gained = ConfirmingGainEntry(
        chi2_before=apart.before.chi2,
        chi2_after=apart.after.chi2,
        gap_closed=gain.gap,
        gain=gain.share,
        gain_ci=(gain.low, gain.high),
        evidence=gain.total,
        evidence_low=gain.total_low,
    )
    return ConfirmationEntry(found.status, found.predicted_worse, apart.windows, gained)


def worst_direction(fitted_model: FittedModel) -> dict[str, float]:
    """Combination of parameters that the logs know least about, in widths of their bounds."""
    return trust.worst_direction(fitted_model.model.space, fitted_model.fit)


def trade(label: str, first: FittedModel, rival: str, second: FittedModel, bench: Bench) -> str:
    """One sentence on what the rest of the model makes up for where a rival takes an effect's place."""
    moved = [
        f"{t.name} {number(t.second, digits)} instead of {in_unit(t.first, t.unit, digits)}"
        for t in trades(first, second, bench.evidence)
        for digits in (telling_apart((t.first, t.second)),)
    ]
    return f"{rival} in place of {label}: {', '.join(moved) if moved else 'all other parameters keep their values'}."


def laws(found: Sequence[LawCheck]) -> tuple[LawEntry, ...]:
    """What a free law of the same argument explains of what each named effect leaves."""
    return tuple(
        LawEntry(
            effect=law.effect,
            argument=law.argument,
            free_parameters=law.free,
            explains=law.gain.gap,
            evidence=law.gain.total,
            evidence_low=law.gain.total_low,
            refuted=law.refuted,
            told=law.sentence if law.refuted else "",
        )
        for law in found
    )


def remaining(score: Score, evidence: EvidenceSettings) -> RemainingEntry:
    """What the last model leaves; `coloured` is noise of the instruments that is larger than the sensors' white one."""
    quiet = at_floor(score, evidence)
    return RemainingEntry("at_floor" if quiet else "unexplained", score.chi2, quiet and beyond_white(score, evidence))


def _own(candidate: Candidate, study: Study) -> Parameters:
    """The effect's fitted parameters; none where it was not fitted."""
    if not candidate.fitted:
        return {}
    fitted_model, evidence = candidate.fitted_model, study.bench.evidence
    table = _marked(estimate(fitted_model.model.space, fitted_model.fit, candidate.windows, evidence))
    return {p.name: table[p.name] for p in candidate.effect.parameters}


def _marked(found: ContextEstimate) -> dict[str, ParameterEntry]:
    """An estimate's table that says which parameters lie at a bound."""
    edge = trust.at_bounds(found)
    return {
        p.name: ParameterEntry(float(value), float(std), p.unit, edge[p.name])
        for p, value, std in zip(found.space.parameters, found.mean, found.std, strict=True)
    }


def _cv_percent(parameter: Parameter, values: Array, mean: float, std: float) -> float:
    """Scatter of the logs' values beside the fitted one.

    It is unknown where one of them ends at a bound, which hides how far it would go. It says nothing beside a value
    that may be 0, such as an angle whose zero lies there.
    """
    known = len(values) > 1 and abs(mean) > std and not any(any(parameter.touches(value)) for value in values.tolist())
    return float(100 * np.std(values, ddof=1) / abs(mean)) if known else float("nan")
