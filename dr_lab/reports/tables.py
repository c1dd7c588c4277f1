"""The tables of a report, as Markdown."""

from collections.abc import Mapping, Sequence
from typing import Any

from dr_lab.reports.ladder import before_after, candidate_name, scored, status, steps
from dr_lab.reports.quantity import ABSENT, number, percent, uncertain

# Tables that hold one column a channel stay readable up to here; machines with more get the table by channel alone.
_COLUMNS = 3


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table, numbers to the right and words to the left; empty without rows."""
    if not rows:
        return ""
    columns = zip(*rows, strict=True)
    rule = ["--:" if all(cell[:1] in f"{ABSENT}-(0123456789" for cell in column) else ":--" for column in columns]
    lines = [[cell.replace("|", r"\|") for cell in row] for row in (header, *rows)]
    lines.insert(1, rule)
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def ladder_table(report: Mapping[str, Any]) -> str:
    """The models from the first to the last: χ² and, for few channels, RMSE (predicted where it is known)."""
    made, channels = steps(report), list(report["noise"])
    shown = channels if len(channels) <= _COLUMNS else []
    diverged = any(step.held_out.get("infeasible_windows") for step in made)
    header = ["model", "χ²", *(f"{_error_name(report)} {_with_unit(report, channel)}" for channel in shown)]
    rows = []
    for step in made:
        errors = [number(_errors(step.held_out).get(channel), 3) for channel in shown]
        windows = [str(step.held_out.get("infeasible_windows", 0))] if diverged else []
        rows.append([step.name, number(step.held_out["chi2"]), *errors, *windows])
    return table([*header, *(["diverged windows"] if diverged else [])], rows)


def error_table(report: Mapping[str, Any]) -> str:
    """RMSE of each channel (predicted where it is known) before and after, beside the noise."""
    pair = before_after(report)
    rows = [
        [
            _with_unit(report, channel),
            *(number(_errors(step.held_out).get(channel), 3) for step in pair),
            number(row["std"], 3),
        ]
        for channel, row in report["noise"].items()
    ]
    return table(
        [
            f"{_error_name(report)} on {scored(report)}",
            *(["before", "after"] if len(pair) == 2 else ["model"]),
            "noise",
        ],
        rows,
    )


def channel_table(report: Mapping[str, Any]) -> str:
    """Noise, RMSE with refitted and with predicted starts, and fit of each channel, before and after."""
    pair = before_after(report)
    times = [" before", " after"] if len(pair) == 2 else [""]
    errors = [f"{kind}{time}" for kind in ("RMSE", "predicted RMSE") for time in times]
    rows = []
    for channel, noise in report["noise"].items():
        values = [
            number(step.held_out.get(key, {}).get(channel), 3) for key in ("rmse", "rmse_predicted") for step in pair
        ]
        fit = percent(_share(pair[-1].held_out.get("fit_percent", {}).get(channel)))
        rows.append([f"`{channel}`", noise["unit"], number(noise["std"], 3), *values, fit])
    return table(["channel", "unit", "noise std", *errors, "fit"], rows)


def ranking_table(ranking: Sequence[Mapping[str, Any]], verdict: str | None) -> str:
    """Candidates, best first: status, χ², gain with its interval and the effect's own parameters."""
    rows = [
        [
            str(place),
            f"`{candidate_name(row)}`",
            status(row, verdict),
            *_outcome(row),
        ]
        for place, row in enumerate(ranking, start=1)
    ]
    return table(["", "effect", "status", "χ²", "gain (interval)", "its parameters"], rows)


def ranking_summary(ranking: Sequence[Mapping[str, Any]], verdict: str | None) -> str:
    """Candidates, best first, without their parameters, which leaves room for whole names on a screen."""
    rows = [[f"`{candidate_name(row)}`", status(row, verdict), *_outcome(row)[:2]] for row in ranking]
    return table(["effect", "status", "χ²", "gain (interval)"], rows)


def _outcome(row: Mapping[str, Any]) -> tuple[str, str, str]:
    """χ², gain and parameters of a candidate; of one that was not fitted, what it promised."""
    if not row.get("fitted", True):
        return ABSENT, f"≈ {percent(max(row['predicted_gain'], 0.0))} promised", ABSENT
    low, high = row["gain_ci"]
    interval = "" if low is None and high is None else f" ({percent(low)} … {percent(high)})"
    gain = f"{percent(row['gain'])}{interval if row.get('final', True) else ', tried on few windows'}"
    return number(row["held_out_chi2"]), gain, "; ".join(_own_parameters(row)) or ABSENT


def parameter_table(parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """Parameters ± std (of one at its bound, that it is), and their scatter between logs where it is known."""
    scatter = any(row.get("cv_percent") is not None for row in parameters.values())
    rows = []
    for name, row in parameters.items():
        spread = [percent(_share(row.get("cv_percent")))] if scatter else []
        rows.append([f"`{name}`", _fitted(row), *spread])
    return table(["parameter", "value ± std", *(["CV between logs"] if scatter else [])], rows)


def per_log_table(parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """Each parameter as fitted on each log alone."""
    logs = list(dict.fromkeys(log for row in parameters.values() for log in row.get("per_log", {})))
    rows = [
        [f"`{name}` [{row['unit']}]", *(number(row.get("per_log", {}).get(log), 3) for log in logs)]
        for name, row in parameters.items()
    ]
    return table(["parameter", *logs], rows) if len(logs) > 1 else ""


def horizon_table(report: Mapping[str, Any]) -> str:
    """RMSE of each channel against the time predicted open loop."""
    horizons = report.get("horizons", [])
    channels = list(dict.fromkeys(channel for row in horizons for channel in row["rmse"]))
    header = ["predicted for", *(f"RMSE {_with_unit(report, channel)}" for channel in channels)]
    rows = [
        [f"{number(row['horizon'], 3)} s", *(number(row["rmse"].get(channel), 3) for channel in channels)]
        for row in horizons
    ]
    return table(header, rows)


def noise_table(noise: Mapping[str, Mapping[str, Any]]) -> str:
    """Noise of each channel, where it is from, and the error that the time step alone makes."""
    numerical = any(row.get("numerical") is not None for row in noise.values())
    rows = []
    for channel, row in noise.items():
        step = [f"{number(row.get('numerical'), 2)} {row['unit']}"] if numerical else []
        rows.append([f"`{channel}`", f"{number(row['std'], 3)} {row['unit']}", row["source"], *step])
    return table(["channel", "noise std", "source", *(["error of the time step"] if numerical else [])], rows)


def clock_table(clocks: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> str:
    """How each channel's clock was aligned: offset, drift and jitter, log by log."""
    rows = [
        [
            log,
            f"`{channel}`",
            clock["clock"],
            f"{number(clock['offset'], 6)} s",
            f"{number(1e6 * clock['drift'], 3)} ppm",
            f"{number(1e3 * clock['jitter'], 3)} ms",
        ]
        for log, channels in clocks.items()
        for channel, clock in channels.items()
    ]
    return table(["log", "channel", "clock", "offset", "drift", "jitter"], rows)


def _own_parameters(row: Mapping[str, Any]) -> list[str]:
    prefix = candidate_name(row) + "."
    return [f"{name.removeprefix(prefix)} {_fitted(entry)}" for name, entry in row["parameters"].items()]


def _fitted(parameter: Mapping[str, Any]) -> str:
    """A value ± std; the std of a value at its bound says nothing."""
    edge = parameter.get("at_bound", False)
    value = uncertain(parameter["value"], None if edge else parameter["std"], parameter["unit"])
    return f"{value}, at its bound" if edge else value


def _errors(held_out: Mapping[str, Any]) -> Mapping[str, float | None]:
    return held_out.get("rmse_predicted") or held_out["rmse"]


def _error_name(report: Mapping[str, Any]) -> str:
    return "predicted RMSE" if report["ladder"][-1]["held_out"].get("rmse_predicted") else "RMSE"


def _with_unit(report: Mapping[str, Any], channel: str) -> str:
    unit = report["noise"].get(channel, {}).get("unit", "")
    return f"{channel} [{unit}]" if unit else channel


def _share(value: float | None) -> float | None:
    return None if value is None else value / 100
