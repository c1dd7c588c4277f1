"""The tables of a report, as Markdown."""

from collections.abc import Mapping, Sequence

from dr_lab.reports.gap import GapReport
from dr_lab.reports.gap_entries import ByChannel, CandidateEntry, ErrorsEntry, NoiseEntry, ParameterEntry, Parameters
from dr_lab.reports.ladder import before_after, scored, status, steps
from dr_lab.reports.quantity import ABSENT, in_unit, number, percent, telling_apart, titled, uncertain
from dr_lab.trajectory import ClockFit

# Tables that hold one column a channel stay readable up to here; machines with more get the table by channel alone.
_COLUMNS = 3
_NOISY = 10.0  # χ² of which noise is a tenth
# Clocks whose times are taken as they are, in words.
_CLOCKS = {"column": "the table's time column", "log": "the log", "publish": "the publishers"}


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table, numbers to the right and words to the left; empty without rows."""
    if not rows:
        return ""
    columns = zip(*rows, strict=True)
    rule = ["--:" if all(cell[:1] in f"{ABSENT}-(0123456789" for cell in column) else ":--" for column in columns]
    lines = [[cell.replace("|", r"\|") for cell in row] for row in (header, *rows)]
    lines.insert(1, rule)
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def ladder_table(report: GapReport) -> str:
    """The models from the first to the last: χ² and, for few channels, RMSE (predicted where it is known)."""
    made, channels = steps(report), list(report.noise)
    shown = channels if len(channels) <= _COLUMNS else []
    diverged = any(step.held_out.infeasible_windows for step in made)
    header = ["model", "χ²", *(f"{_error_name(report)} {_with_unit(report, channel)}" for channel in shown)]
    rows = []
    for step in made:
        errors = [number(_errors(step.held_out).get(channel), 3) for channel in shown]
        windows = [str(step.held_out.infeasible_windows)] if diverged else []
        rows.append([step.name, number(step.held_out.chi2), *errors, *windows])
    return table([*header, *(["diverged windows"] if diverged else [])], rows)


def error_table(report: GapReport) -> str:
    """RMSE of each channel (predicted where it is known) before and after, beside the noise."""
    pair = before_after(report)
    rows = [
        [
            _with_unit(report, channel),
            *(number(_errors(step.held_out).get(channel), 3) for step in pair),
            number(row.std, 3),
        ]
        for channel, row in report.noise.items()
    ]
    return table(
        [
            f"{_error_name(report)} on {scored(report)}",
            *(["before", "after"] if len(pair) == 2 else ["model"]),
            "noise",
        ],
        rows,
    )


def channel_table(report: GapReport) -> str:
    """Noise, RMSE with refitted and with predicted starts, and fit of each channel, before and after."""
    pair = before_after(report)
    times = [" before", " after"] if len(pair) == 2 else [""]
    errors = [f"{kind}{time}" for kind in ("RMSE", "predicted RMSE") for time in times]
    rows = []
    for channel, noise in report.noise.items():
        values = [
            number(errors.get(channel), 3)
            for errors in (*(step.held_out.rmse for step in pair), *(step.held_out.rmse_predicted for step in pair))
        ]
        fit = percent(_share(pair[-1].held_out.fit_percent.get(channel)))
        rows.append([f"`{channel}`", noise.unit, number(noise.std, 3), *values, fit])
    return table(["channel", "unit", "noise std", *errors, "fit, starts fitted"], rows)


def ranking_table(ranking: Sequence[CandidateEntry], verdict: str | None, confidence: float | None) -> str:
    """Candidates, best first: status, χ², the share of χ² removed with its interval, and their own parameters."""
    rows = [
        [
            str(place),
            f"`{row.label}`",
            status(row, verdict),
            *_outcome(row),
        ]
        for place, row in enumerate(ranking, start=1)
    ]
    return table(["", "effect", "status", "χ²", _removed(confidence), "its parameters"], rows)


def promise_table(ranking: Sequence[CandidateEntry], verdict: str | None, first: int) -> str:
    """Candidates that were not fitted, from place `first` on: status, and the gain that a linear step foretells."""
    rows = [
        [str(place), f"`{row.label}`", status(row, verdict), _promised(row)]
        for place, row in enumerate(ranking, start=first)
    ]
    return table(["", "effect", "status", "promised"], rows)


def ranking_summary(ranking: Sequence[CandidateEntry], verdict: str | None, confidence: float | None) -> str:
    """Candidates, best first, without their parameters, which leaves room for whole names on a screen."""
    rows = [[f"`{row.label}`", status(row, verdict), *_outcome(row)[:2]] for row in ranking]
    return table(["effect", "status", "χ²", _removed(confidence)], rows)


def intervals_of(confidence: float | None) -> str:
    """What intervals are called: with their confidence, which older files lack."""
    return "interval" if confidence is None else f"{100 * confidence:.3g} % interval"


def _removed(confidence: float | None) -> str:
    return f"χ² removed in a typical window ({intervals_of(confidence)})"


def noise_included(report: GapReport) -> str:
    """That no effect removes all of χ², where noise is a good part of it; empty where it is not."""
    chi2 = report.ladder[0].held_out.chi2
    if chi2 is None or not 1.0 < chi2 < _NOISY:
        return ""
    return (
        f"χ² holds the noise, which no effect removes: of {number(chi2)} at most {percent(1 - 1 / chi2)} can go. The "
        "first sentences leave the noise out."
    )


def _outcome(row: CandidateEntry) -> tuple[str, str, str]:
    """χ², gain and parameters of a candidate; of one that was not fitted, what it promised."""
    if not row.fitted:
        return ABSENT, f"{_promised(row)} promised", ABSENT
    low, high = row.gain_ci
    interval = "" if low is None and high is None else f" ({percent(low)} … {percent(high)})"
    gain = f"{percent(row.gain)}{interval if row.final else ', tried on few windows'}"
    return number(row.held_out_chi2), gain, "; ".join(_own_parameters(row)) or ABSENT


def _promised(row: CandidateEntry) -> str:
    return f"≈ {percent(None if row.predicted_gain is None else max(row.predicted_gain, 0.0))}"


def parameter_table(parameters: Parameters, given: Mapping[str, float]) -> str:
    """Parameters ± std (of one at its bound, that it is), the values given, and their scatter between logs."""
    scatter = any(_cv_percent(row) is not None for row in parameters.values())
    before = any(name in given for name in parameters)
    rows = []
    for name, row in parameters.items():
        first = [number(given.get(name))] if before else []
        spread = [percent(_share(_cv_percent(row)))] if scatter else []
        rows.append([f"`{name}`", *first, _fitted(row), *spread])
    told = "value ± std" if any("±" in cell for row in rows for cell in row) else "value"
    header = ["parameter", *(["as given"] if before else []), told]
    return table([*header, *(["CV between logs"] if scatter else [])], rows)


def per_log_table(parameters: Parameters) -> str:
    """Each parameter as fitted on each log alone."""
    logs = list(dict.fromkeys(log for row in parameters.values() for log in _per_log(row)))
    rows = []
    for name, row in parameters.items():
        each = _per_log(row)
        rows.append(
            [titled(f"`{name}`", row.unit), *(number(each.get(log), telling_apart(each.values())) for log in logs)]
        )
    return table(["parameter", *logs], rows) if len(logs) > 1 else ""


def horizon_table(report: GapReport) -> str:
    """RMSE of each channel against the time predicted open loop."""
    horizons = report.failing.horizons
    channels = list(dict.fromkeys(channel for row in horizons for channel in row.rmse))
    header = ["predicted for", *(f"RMSE {_with_unit(report, channel)}" for channel in channels)]
    rows = [
        [f"{number(row.horizon, 3)} s", *(number(row.rmse.get(channel), 3) for channel in channels)] for row in horizons
    ]
    return table(header, rows)


def noise_table(noise: Mapping[str, NoiseEntry]) -> str:
    """Noise of each channel, where it is from, and the error that the time step alone makes."""
    numerical = any(row.numerical is not None for row in noise.values())
    rows = []
    for channel, row in noise.items():
        step = [in_unit(row.numerical, row.unit, 2)] if numerical else []
        rows.append([f"`{channel}`", in_unit(row.std, row.unit, 3), row.source, *step])
    return table(["channel", "noise std", "source", *(["error of the time step"] if numerical else [])], rows)


def clock_table(clocks: Mapping[str, Mapping[str, ClockFit]]) -> str:
    """How each channel's clock was aligned: offset, drift and jitter, log by log; a sentence where none was."""
    every = [(log, channel, clock) for log, channels in clocks.items() for channel, clock in channels.items()]
    if every and not any(clock.fitted for _, _, clock in every):
        named = " and ".join(dict.fromkeys(_CLOCKS.get(clock.clock, clock.clock) for _, _, clock in every))
        return f"No clock was aligned: all times are those of {named}, as they are."
    rows = [[log, f"`{channel}`", clock.clock, *_alignment(clock)] for log, channel, clock in every]
    return table(["log", "channel", "clock", "offset", "drift", "jitter"], rows)


def _alignment(clock: ClockFit) -> tuple[str, str, str]:
    """Offset, drift and jitter; dashes where the times were taken as they are."""
    if not clock.fitted:
        return ABSENT, ABSENT, ABSENT
    return f"{number(clock.offset, 6)} s", f"{number(1e6 * clock.drift, 3)} ppm", f"{number(1e3 * clock.jitter, 3)} ms"


def _own_parameters(row: CandidateEntry) -> list[str]:
    prefix = row.label + "."
    return [f"{name.removeprefix(prefix)} {_fitted(entry)}" for name, entry in row.parameters.items()]


def _fitted(parameter: ParameterEntry) -> str:
    """A value ± std; the std of a value at its bound says nothing."""
    value = uncertain(parameter.value, None if parameter.at_bound else parameter.std, parameter.unit)
    return f"{value}, at its bound" if parameter.at_bound else value


def _cv_percent(parameter: ParameterEntry) -> float | None:
    return None if parameter.scatter is None else parameter.scatter.cv_percent


def _per_log(parameter: ParameterEntry) -> ByChannel:
    return {} if parameter.scatter is None else parameter.scatter.per_log


def _errors(held_out: ErrorsEntry) -> ByChannel:
    return held_out.rmse_predicted or held_out.rmse


def _error_name(report: GapReport) -> str:
    return "predicted RMSE" if report.ladder[-1].held_out.rmse_predicted else "RMSE"


def _with_unit(report: GapReport, channel: str) -> str:
    unit = report.noise[channel].unit if channel in report.noise else ""
    return titled(channel, unit)


def _share(value: float | None) -> float | None:
    return None if value is None else value / 100
