"""Entries of `report.json` (schema dr_lab/gap/1) made from what the diagnosis found."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from dr_lab.comparison.notes import study_notes
from dr_lab.comparison.study import Study
from dr_lab.diagnosis.discrepancy import HorizonError
from dr_lab.diagnosis.evidence.bench import Bench, FittedModel
from dr_lab.diagnosis.evidence.confirmation import Confirmation
from dr_lab.diagnosis.evidence.paired_gain import at_floor, noise_floor
from dr_lab.diagnosis.evidence.score import Score
from dr_lab.diagnosis.evidence.trade import trades
from dr_lab.diagnosis.fit import trust
from dr_lab.diagnosis.fit.covariance import estimate, per_log
from dr_lab.diagnosis.fit.levenberg_marquardt import Fit
from dr_lab.diagnosis.localise import Region
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.law_check import LawCheck
from dr_lab.diagnosis.search.verdict import Verdict
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.physics.context import ContextEstimate
from dr_lab.trajectory import Array, MeasurementSet

SCHEMA = "dr_lab/gap/1"


def header(verb: str, study: Study) -> dict[str, Any]:
    """What every report starts with: names, noise and numerical floors, notes on the data, clocks."""
    measured = study.measurements
    return {
        "schema": SCHEMA,
        "verb": verb,
        "model": study.model.name,
        "measurements": measured.name,
        "noise": {
            name: {
                "std": noise.std,
                "unit": noise.unit,
                "source": noise.source,
                "numerical": study.floor.error.get(name),
            }
            for name, noise in measured.noise.items()
        },
        "logs": {"fit": [log.name for log in measured.fit], "held_out": [log.name for log in measured.held_out]},
        "windows": _windows(study),
        "clocks": _clocks(measured),
        "notes": study_notes(study),
    }


def _windows(study: Study) -> dict[str, Any]:
    """How long and how many windows are."""
    bench = study.bench
    return {
        "length": study.settings.windows.length,
        "fit": len(bench.fit),
        "held_out": len(bench.held_out),
        "confirm": 0 if bench.confirms is None else len(bench.confirms),
    }


def rung(labels: Sequence[str], refitted: Score, predicted: Score, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """One model of the ladder."""
    return {
        "effects": list(labels),
        "held_out": {
            "chi2": refitted.chi2,
            "degrees_of_freedom": refitted.freedom,
            "rmse": refitted.rmse,
            "nrmse": refitted.nrmse,
            "fit_percent": refitted.fit_percent,
            "chi2_predicted": predicted.chi2,
            "rmse_predicted": predicted.rmse,
            "infeasible_windows": refitted.infeasible,
        },
        "parameters": dict(parameters),
    }


def fitted(fit: Fit) -> dict[str, Any]:
    """How a fit ended, and how many of its windows diverge and took no part in it."""
    return {
        "converged": fit.converged,
        "iterations": fit.iterations,
        "windows": len(fit.infeasible),
        "infeasible_windows": int(fit.infeasible.sum()),
    }


def parameters(study: Study, explained: FittedModel) -> tuple[ContextEstimate, dict[str, Any]]:
    """Estimate of a fitted context and its table, with the scatter between logs in percent (CV)."""
    space, bench = explained.model.space, study.bench
    found = estimate(space, explained.fit, bench.fit, bench.evidence)
    logs = per_log(space, explained.fit, bench.fit)
    doubted = trust.doubts(found, explained.fit, bench.fit, bench.evidence)
    table = _marked(found)
    for column, name in enumerate(space.names):
        table[name]["cv_percent"] = _cv_percent(logs[:, column], float(found.mean[column]))
        table[name]["per_log"] = dict(zip(bench.fit.logs, logs[:, column].tolist(), strict=True))
        table[name]["doubts"] = doubted[name]
        table[name]["bounds"] = [float(space.low[column]), float(space.high[column])]
    return found, table


def ranking(study: Study, found: Sequence[Candidate], verdict: Verdict) -> list[dict[str, Any]]:
    """Candidates in the verdict's order; `gain` is the share of a typical window's χ² that an effect removes.

    Of a candidate that was tried on a part of the fitted windows alone, and beaten there, all figures are from these.
    """
    rows = []
    order = {label: place for place, label in enumerate(verdict.effects)}
    for candidate in sorted(found, key=lambda c: order.get(c.effect.label, len(order))):
        label = candidate.effect.label
        rows.append(
            {
                "effect": candidate.effect.effect.name,
                "site": candidate.effect.site,
                "held_out_chi2": candidate.explained.held_out.chi2 if candidate.final or not candidate.fitted else None,
                "gain": candidate.gain.share,
                "gain_ci": [candidate.gain.low, candidate.gain.high],
                "evidence": candidate.gain.total,
                "evidence_low": candidate.gain.total_low,
                "wins": candidate.gain.wins,
                "fitted": candidate.fitted,
                "final": candidate.final,
                "gap_closed": dict(candidate.gain.channels),
                "predicted_gain": candidate.predicted,
                "status": verdict.status[label],
                "absorbed_by_parameters": label in verdict.absorbed,
                "replaced_by": _replaced_by(candidate, study.bench.evidence.replacement_share)
                if label in verdict.absorbed
                else {},
                "excitation": candidate.identifiability.alone**0.5,
                "parameters": _own(candidate, study),
            }
        )
    return rows


def _replaced_by(candidate: Candidate, told: float) -> dict[str, float]:
    """Parameters that take the effect's place, in widths of their bounds for a full width of the effect."""
    moves = candidate.identifiability.replacement
    names, largest = candidate.explained.model.space.names, float(np.abs(moves).max(initial=0.0))
    order = np.argsort(-np.abs(moves))
    return {names[k]: float(moves[k]) for k in order if abs(moves[k]) >= told * largest}


def confirmation(found: Confirmation | None) -> dict[str, Any] | None:
    """What the windows that chose nothing say; null where nothing was added."""
    if found is None:
        return None
    entry: dict[str, Any] = {"status": found.status, "predicted_worse": found.predicted_worse, "windows": 0}
    if found.apart is not None:
        apart, gain = found.apart, found.apart.gain
        entry |= {"windows": apart.windows, "chi2_before": apart.before.chi2, "chi2_after": apart.after.chi2}
        entry |= {"gap_closed": gain.gap, "gain": gain.share, "gain_ci": [gain.low, gain.high]}
        entry |= {"evidence": gain.total, "evidence_low": gain.total_low}
    return entry


def worst_direction(explained: FittedModel) -> dict[str, float]:
    """Combination of parameters that the logs know least about, in widths of their bounds."""
    return trust.worst_direction(explained.model.space, explained.fit)


def trade(label: str, first: FittedModel, rival: str, second: FittedModel, bench: Bench) -> str:
    """One sentence on what the rest of the model makes up for where a rival takes an effect's place."""
    moved = [
        f"{t.name} {t.second:.4g} instead of {t.first:.4g} {t.unit}" for t in trades(first, second, bench.evidence)
    ]
    return f"{rival} in place of {label}: {', '.join(moved) if moved else 'all other parameters keep their values'}."


def laws(found: Sequence[LawCheck]) -> list[dict[str, Any]]:
    """What a free law of the same argument explains of what each named effect leaves."""
    return [
        {
            "effect": law.effect,
            "argument": law.argument,
            "free_parameters": law.free,
            "explains": law.gain.gap,
            "evidence": law.gain.total,
            "evidence_low": law.gain.total_low,
            "refuted": law.refuted,
            "told": law.sentence if law.refuted else "",
        }
        for law in found
    ]


def horizons(error: HorizonError) -> list[dict[str, Any]]:
    """Error against the time predicted open loop."""
    return [
        {"horizon": float(edge), "rmse": {name: float(values[i]) for name, values in error.rmse.items()}}
        for i, edge in enumerate(error.horizon)
    ]


def where(regions: Sequence[Region]) -> list[dict[str, Any]]:
    """Regions that hold most of the error."""
    return [
        {"signal": r.signal, "region": r.region, "share": r.share, "samples": r.samples, "chi2": r.chi2}
        for r in regions
    ]


def remaining(score: Score, evidence: EvidenceSettings) -> dict[str, Any]:
    """What the last model leaves; `coloured` is noise of the instruments that is larger than the sensors' white one."""
    return {
        "status": "at_floor" if at_floor(score, evidence) else "unexplained",
        "chi2": score.chi2,
        "coloured": at_floor(score, evidence) and score.chi2 > noise_floor(score.freedom, evidence),
    }


def _own(candidate: Candidate, study: Study) -> dict[str, Any]:
    """The effect's fitted parameters; none where it was not fitted."""
    if not candidate.fitted:
        return {}
    explained, bench = candidate.explained, study.bench
    windows = bench.fit if candidate.final else bench.screening().fit
    table = _marked(estimate(explained.model.space, explained.fit, windows, bench.evidence))
    return {p.name: table[p.name] for p in candidate.effect.parameters}


def _marked(found: ContextEstimate) -> dict[str, Any]:
    """An estimate's table that says which parameters lie at a bound."""
    edge = trust.at_bounds(found)
    return {name: {**row, "at_bound": edge[name]} for name, row in found.table().items()}


def _cv_percent(values: Array, mean: float) -> float:
    return float(100 * np.std(values, ddof=1) / abs(mean)) if len(values) > 1 and mean else float("nan")


def _clocks(measured: MeasurementSet) -> dict[str, Any]:
    return {
        log.name: {
            channel: {"clock": fit.clock, "offset": fit.offset, "drift": fit.drift, "jitter": fit.jitter}
            for channel, fit in log.clocks.items()
        }
        for log in (*measured.fit, *measured.held_out)
        if log.clocks
    }
