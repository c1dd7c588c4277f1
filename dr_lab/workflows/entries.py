"""Entries of `report.json` (schema dr_lab/gap/1) made from what the diagnosis found."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from dr_lab.diagnosis import trust
from dr_lab.diagnosis.channels import unmeasured_joints
from dr_lab.diagnosis.commands import silent_actuators
from dr_lab.diagnosis.covariance import estimate, per_log
from dr_lab.diagnosis.discrepancy import HorizonError
from dr_lab.diagnosis.evidence import block_count, noise_floor
from dr_lab.diagnosis.fit import Fit
from dr_lab.diagnosis.localise import Region
from dr_lab.diagnosis.rank import Bench, Candidate, Explained
from dr_lab.diagnosis.score import Score
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.diagnosis.trade import trades
from dr_lab.diagnosis.unit_suspicion import suspect_degrees
from dr_lab.diagnosis.verdict import Verdict
from dr_lab.physics.context import ContextEstimate
from dr_lab.trajectory import Array, MeasurementSet
from dr_lab.workflows.study import Study

SCHEMA = "dr_lab/gap/1"
_TOLD = 0.2  # of the largest move of a parameter that takes an effect's place


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
        "windows": {"length": study.windows.length, "fit": len(study.bench.fit), "held_out": len(study.bench.held_out)},
        "clocks": _clocks(measured),
        "notes": [
            *_unit_note(study),
            *_step_note(study),
            *_silent_notes(study),
            *_split_note(measured),
            *_data_notes(measured),
        ],
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


def fit_notes(models: Sequence[Explained]) -> list[dict[str, Any]]:
    """Notes on fits of a ladder's models that lack windows or did not converge."""
    notes = []
    for model in models:
        effects, end = model.model.effects, fitted(model.fit)
        name = f"The fit with {effects[-1].label}" if effects else "The calibration"
        if end["infeasible_windows"]:
            told = f"{name} lacks {end['infeasible_windows']} of {end['windows']} windows, whose simulation diverges."
            notes.append({"kind": "infeasible_windows", "message": f"{told} Its parameters hold for the others alone."})
        if not end["converged"]:
            told = f"{name} did not converge in {end['iterations']} steps: its parameters may not be the best."
            notes.append({"kind": "not_converged", "message": f"{told} Raise solver.iterations, or begin nearer."})
    return notes


def parameters(study: Study, explained: Explained) -> tuple[ContextEstimate, dict[str, Any]]:
    """Estimate of a fitted context and its table, with the scatter between logs in percent (CV)."""
    space, bench = explained.model.space, study.bench
    found = estimate(space, explained.fit, bench.fit, bench.evidence)
    logs = per_log(space, explained.fit, bench.fit)
    doubted = trust.doubts(found, explained.fit, bench.fit, bench.evidence)
    table: dict[str, Any] = found.table()
    for column, name in enumerate(space.names):
        table[name]["cv_percent"] = _cv_percent(logs[:, column], float(found.mean[column]))
        table[name]["per_log"] = dict(zip(bench.fit.logs, logs[:, column].tolist(), strict=True))
        table[name]["doubts"] = doubted[name]
        table[name]["bounds"] = [float(space.low[column]), float(space.high[column])]
    return found, table


def ranking(study: Study, found: Sequence[Candidate], verdict: Verdict) -> list[dict[str, Any]]:
    """Candidates in the verdict's order; `gain` is the share of the χ² on the scored logs that an effect removes."""
    rows = []
    order = {label: place for place, label in enumerate(verdict.effects)}
    for candidate in sorted(found, key=lambda c: order.get(c.effect.label, len(order))):
        label = candidate.effect.label
        rows.append(
            {
                "effect": candidate.effect.effect.name,
                "site": candidate.effect.site,
                "held_out_chi2": candidate.explained.held_out.chi2,
                "gain": candidate.gain.share,
                "gain_ci": [candidate.gain.low, candidate.gain.high],
                "evidence": candidate.gain.total,
                "evidence_low": candidate.gain.total_low,
                "wins": candidate.gain.wins,
                "fitted": candidate.fitted,
                "predicted_gain": candidate.predicted,
                "status": verdict.status[label],
                "absorbed_by_parameters": label in verdict.absorbed,
                "replaced_by": _replaced_by(candidate) if label in verdict.absorbed else {},
                "excitation": candidate.identifiability.alone**0.5,
                "parameters": _own(candidate, study),
            }
        )
    return rows


def _replaced_by(candidate: Candidate) -> dict[str, float]:
    """Parameters that take the effect's place, in widths of their bounds for a full width of the effect."""
    moves = candidate.identifiability.replacement
    names, largest = candidate.explained.model.space.names, float(np.abs(moves).max(initial=0.0))
    order = np.argsort(-np.abs(moves))
    return {names[k]: float(moves[k]) for k in order if abs(moves[k]) >= _TOLD * largest}


def worst_direction(explained: Explained) -> dict[str, float]:
    """Combination of parameters that the logs know least about, in widths of their bounds."""
    return trust.worst_direction(explained.model.space, explained.fit)


def trade(label: str, first: Explained, rival: str, second: Explained, bench: Bench) -> str:
    """One sentence on what the rest of the model makes up for where a rival takes an effect's place."""
    moved = [
        f"{t.name} {t.second:.4g} instead of {t.first:.4g} {t.unit}" for t in trades(first, second, bench.evidence)
    ]
    return f"{rival} in place of {label}: {', '.join(moved) if moved else 'all other parameters keep their values'}."


def few_blocks(bench: Bench) -> list[dict[str, Any]]:
    """Note that the held-out windows are too few for an interval of any difference between models."""
    count, least = block_count(bench.held_out.log, bench.evidence), bench.evidence.least_compared
    if count >= least:
        return []
    message = (
        f"The held-out windows make {count} block{'s' if count > 1 else ''} of data; from {least} on "
        "(evidence.least_compared) the scatter of gains is known. Here an effect counts that lowers the error in every "
        f"window and closes {100 * bench.evidence.least_named:g} % of the gap (evidence.least_named): do not trust it "
        "far. Record more, hold out more logs or cut shorter windows (windows.length)."
    )
    return [{"kind": "few_blocks", "message": message, "count": count}]


def refused(reasons: Mapping[str, str]) -> list[dict[str, Any]]:
    """Notes on effects that were not tried, one for each reason.

    Args:
        reasons: why, by ``effect@site``.
    """
    return [
        {"kind": "not_tried", "message": f"Not tried: {', '.join(k for k in reasons if reasons[k] == why)}. {why}"}
        for why in dict.fromkeys(reasons.values())
    ]


def dropped(labels: Sequence[str]) -> list[dict[str, Any]]:
    """Notes on effects that later ones made superfluous."""
    told = "was added, and dropped again: beside the effects that followed, the logs do without it."
    return [{"kind": "dropped", "message": f"{label} {told}"} for label in labels]


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


def remaining(chi2: float, freedom: float, evidence: EvidenceSettings) -> dict[str, Any]:
    """What the last model leaves, by its χ² over that many degrees of freedom."""
    return {"status": "at_floor" if chi2 <= noise_floor(freedom, evidence) else "unexplained", "chi2": chi2}


def _own(candidate: Candidate, study: Study) -> dict[str, Any]:
    """The effect's fitted parameters; none where it was not fitted."""
    if not candidate.fitted:
        return {}
    explained = candidate.explained
    table = estimate(explained.model.space, explained.fit, study.bench.fit, study.bench.evidence).table()
    return {p.name: table[p.name] for p in candidate.effect.parameters}


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


def _unit_note(study: Study) -> list[dict[str, Any]]:
    bench = study.bench
    found = suspect_degrees(study.model, study.measurements, study.windows, bench.solver, bench.threads)
    if found is None:
        return []
    names = ", ".join(found.channels)
    message = (
        f"{names} in radians, as declared, leave χ² {found.chi2:.3g}; read as degrees {found.chi2_degrees:.3g}: the "
        "factor 57.3 = 180/π is suspected. Write unit: deg if the numbers are degrees."
    )
    return [{"kind": "unit", "message": message}]


def _step_note(study: Study) -> list[dict[str, Any]]:
    coarse = {name: share for name, share in study.floor.share.items() if share > 1}
    if not coarse:
        return []
    worst = max(coarse, key=lambda name: coarse[name])
    message = (
        f"The time step of {study.floor.step:g} s alone moves {worst} by {coarse[worst]:.2g} noise standard deviations "
        f"within a window, which can pass for missing physics. Set timestep {study.floor.proposed:g} s in the MJCF."
    )
    return [{"kind": "time_step", "signal": worst, "message": message}]


def _silent_notes(study: Study) -> list[dict[str, Any]]:
    """What the model has and the measurements do not name."""
    logs = (*study.measurements.fit, *study.measurements.held_out)
    sent, shown = (", ".join(signals) or "none" for signals in (logs[0].commands, logs[0].outputs))
    notes = []
    if actuators := silent_actuators(study.compiled, logs):
        message = (
            f"No command is measured for {', '.join(actuators)}: simulated with the control 0. Measured commands: "
            f"{sent}. If it was driven, name its channel in measurements.commands."
        )
        notes.append({"kind": "no_command", "message": message})
    if joints := unmeasured_joints(study.compiled, tuple(logs[0].outputs)):
        message = (
            f"No position or velocity is measured of joint {', '.join(joints)}: what it does is guessed from the other "
            f"channels. Measured: {shown}. If a log holds it, name its channel in measurements.outputs."
        )
        notes.append({"kind": "no_output", "message": message})
    return notes


def _split_note(measured: MeasurementSet) -> list[dict[str, Any]]:
    if measured.held_out:
        return []
    message = "No log is held out: all scores are on the fit logs, which flatter what is fitted to them."
    return [{"kind": "no_held_out", "message": message}]


def _data_notes(measured: MeasurementSet) -> list[dict[str, Any]]:
    return [
        {"log": log.name, "kind": note.kind, "signal": note.signal, "message": note.message, "count": note.count}
        for log in (*measured.fit, *measured.held_out)
        for note in log.notes
    ]
