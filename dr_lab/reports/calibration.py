"""What calibrating changed in the model's own parameters, and which effects that change may stand for."""

from dr_lab.reports.gap import GapReport
from dr_lab.reports.gap_entries import ParameterEntry
from dr_lab.reports.quantity import number, percent

_STDS = 2.0  # stated standard deviations; a smaller change is none beyond 95 %
_MOST = 4  # parameters that a sentence lists


def calibration_told(report: GapReport) -> str:
    """Which parameters of the model left the values given, and the effects that would look like that.

    A calibrated model may need no effect because its masses took over what is wrong with a motor. The logs cannot tell
    that, hence it is told.

    Returns:
        One or two sentences; empty where nothing was calibrated or nothing left its value beyond twice its ±.
    """
    moved = _moved(report)
    if not moved:
        return ""
    listed = ", ".join(f"`{name}` {change}" for name, change in list(moved.items())[:_MOST])
    more = f" and {len(moved) - _MOST} more" if len(moved) > _MOST else ""
    told = f"Calibrating changed {listed}{more}."
    takers = {row.label: [name for name in row.replaced_by if name in moved] for row in report.judged.ranking}
    # A joint's damping is its viscous friction: to say that of two names for one thing would tell nothing.
    other = {label: names for label, names in takers.items() if any(not _of_its_site(label, n) for n in names)}
    if not other:
        return told
    names = list(dict.fromkeys(name for each in other.values() for name in each))[:_MOST]
    effects, them = " or ".join(f"`{label}`" for label in other), " and ".join(f"`{name}`" for name in names)
    return f"{told} **{effects} would look the same as the change of {them}:** measure what you can of these to tell."


def given_values(report: GapReport) -> dict[str, float]:
    """Each parameter's value in the model as given; empty where the report has no such model apart."""
    given = {} if report.as_given is None else report.as_given.parameters
    return {name: row.value for name, row in given.items() if row.value is not None}


def _moved(report: GapReport) -> dict[str, str]:
    """The change of each parameter that left its value, largest in its ± first."""
    last, given = report.catalogued[-1].parameters, given_values(report)
    sizes = {name: _stds(last[name], value) for name, value in given.items() if name in last}
    names = sorted((name for name in sizes if sizes[name] > _STDS), key=lambda name: -sizes[name])
    return {name: _change(last[name], given[name]) for name in names}


def _stds(row: ParameterEntry, given: float) -> float:
    """How many of its standard deviations a value is from the one given; 0 where neither is known."""
    if row.value is None or not row.std:
        return 0.0
    return abs(row.value - given) / row.std


def _change(row: ParameterEntry, given: float) -> str:
    unit = "" if row.unit in ("", "1") else f" {row.unit}"
    moved = f"{number(given, 3)} → {number(row.value, 3)}{unit}"
    if not given or row.value is None:
        return moved
    share = row.value / given - 1.0
    return f"{moved} ({'+' if share > 0 else '−'}{percent(abs(share))})"


def _of_its_site(label: str, parameter: str) -> bool:
    """Whether a parameter is named after the site of an effect, as `dr-lab init` names them."""
    return parameter.startswith(label.partition("@")[2] + ".")
