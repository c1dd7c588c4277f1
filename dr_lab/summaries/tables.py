"""The tables of a sweep: Markdown to be read, CSV to be worked with."""

from collections.abc import Mapping, Sequence

from dr_lab.evaluators.statistics import Interval
from dr_lab.reports.csv_rows import rows_csv
from dr_lab.reports.interval_level import levels_told
from dr_lab.reports.page import Page, Section
from dr_lab.reports.quantity import number, titled, written
from dr_lab.reports.tables import table
from dr_lab.summaries.groups import (
    Cell,
    Cells,
    Estimate,
    Group,
    Statistics,
    figures_of,
    is_known,
    known_in,
)
from dr_lab.summaries.runs import Figure, Run
from dr_lab.sweeps.overrides import differing

_INTERVALS = "Interquartile means over the runs of a row, with {:g} % bootstrap intervals of three runs or more."
_LARGER = (
    "larger is the probability that the figure is larger in one of these runs than in one of {}: 0.5 where neither is "
    "better, in doubt as long as its interval holds 0.5. It is left out where runs are so few that chance alone would "
    "often put all of one row above all of the other."
)

_TOLD = 4  # groups that the first sentence compares
_COMMON = "figures."  # path of all figures of an evaluation, which leaves too little of a narrow screen


def summary_page(
    sweep: str,
    groups: Sequence[Group],
    cells: Sequence[Cells],
    shared: Mapping[str, Figure],
    notes: Sequence[str],
    statistics: Statistics,
    reference: Group,
    units: Mapping[str, str],
) -> Page:
    """What differs between groups, and their figures; those that all runs share, in one sentence.

    Args:
        sweep: its name.
        groups: of runs.
        cells: the figures of each.
        shared: figures that are the same in every run.
        notes: sentences for its end.
        statistics: how the runs of a group were summed up.
        reference: the group that the others are compared with.
        units: of figures that have one, by path.
    """
    keys = list(groups[0].settings)
    rows = [
        [_named(name, units), *(group.settings[key] for key in keys), *_told(row[name], len(group.runs))]
        for name in dict.fromkeys(name for row in cells for name in row)
        if name not in shared
        for group, row in zip(groups, cells, strict=True)
        if name in row
    ]
    alike = ", ".join(f"{name} {written(value)} {units.get(name, '')}".rstrip() for name, value in shared.items())
    told = [f"The same in all runs: {alike}."] if shared else []
    count = sum(len(group.runs) for group in groups)
    columns, about = [*_short(keys), "runs", "mean (interval)"], [_INTERVALS.format(100 * statistics.confidence)]
    sizes = [cell.runs for row in cells for cell in row.values() if isinstance(cell, Estimate)]
    about += filter(None, [levels_told(statistics.confidence, sizes)])
    if any(row[-1] for row in rows):
        columns, about = [*columns, "larger"], [*about, _LARGER.format(reference.label)]
    found = table(["figure", *columns], [row[: len(columns) + 1] for row in rows])
    sections = [Section("figures", "", found), Section("notes", "", "\n\n".join([*told, *notes]))]
    return Page(f"{count} runs of {sweep}", " ".join([*_first(groups, cells, units), *about]), sections)


def _named(name: str, units: Mapping[str, str]) -> str:
    return titled(name.removeprefix(_COMMON), units.get(name, ""))


def _first(groups: Sequence[Group], cells: Sequence[Cells], units: Mapping[str, str]) -> list[str]:
    """The first figure of a few groups, largest first; nothing of more, which the table compares."""
    name = next((name for row in cells for name, cell in row.items() if isinstance(cell, Estimate)), "")
    found = [(group.label, row.get(name)) for group, row in zip(groups, cells, strict=True)]
    known = [(label, cell) for label, cell in found if isinstance(cell, Estimate) and cell.runs]
    if not 1 < len(known) <= _TOLD:
        return []
    ordered = sorted(known, key=lambda pair: -pair[1].value)
    return [f"**{_named(name, units)}:** {'; '.join(f'`{label}` {_interval(cell)}' for label, cell in ordered)}."]


def _short(keys: Sequence[str]) -> list[str]:
    """The last part of each key, for screens are narrow; the whole key where two have the same."""
    last = [key.rpartition(".")[2] for key in keys]
    return [short if last.count(short) == 1 else key for short, key in zip(last, keys, strict=True)]


def _told(cell: Cell, members: int) -> list[str]:
    """Of how many runs of a group a figure is, the figure, and whether it is larger than that of the reference."""
    larger = cell.larger if isinstance(cell, Estimate) else None
    known = "" if larger is None or larger.low != larger.low else _interval(larger)  # of few runs it is 0 or 1
    return [_runs(cell, members), _cell(cell), known]


def _runs(cell: Cell, members: int) -> str:
    """Of how many runs of a group a figure is."""
    known = known_in(cell)
    return str(members) if known == members else f"{known} of {members}"


def _cell(cell: Cell) -> str:
    if not isinstance(cell, Estimate):
        return ", ".join(f"{word} ({count})" for word, count in cell.items())
    return _interval(cell)


def _interval(found: Interval) -> str:
    if found.low != found.low:  # one run has no interval
        return number(found.value)
    return f"{number(found.value)} ({number(found.low)} … {number(found.high)})"


def _runs_table(runs: Sequence[Run], figures: Mapping[str, Sequence[str]]) -> list[dict[str, Figure]]:
    keys = differing([run.overrides for run in runs])
    picked = [figures_of(run, figures) for run in runs]
    names = list(dict.fromkeys(name for row in picked for name in row))
    return [
        {"run": run.name}
        | {key: run.overrides.get(key, "") for key in keys}
        | {name: row[name] if is_known(row.get(name)) else "" for name in names}
        for run, row in zip(runs, picked, strict=True)
    ]


def runs_page(runs: Sequence[Run], figures: Mapping[str, Sequence[str]], units: Mapping[str, str]) -> str:
    """Every run with what differs, as Markdown; figures with their units, by path."""
    rows = _runs_table(runs, figures)
    cells = [[written(value) for value in row.values()] for row in rows]
    return table([titled(name, units.get(name, "")) for name in rows[0]], cells) + "\n"


def runs_csv(runs: Sequence[Run], figures: Mapping[str, Sequence[str]]) -> str:
    """Every run with what differs, one row each."""
    return rows_csv(_runs_table(runs, figures))


def groups_csv(groups: Sequence[Group], cells: Sequence[Cells]) -> str:
    """Every group with its figures, one row each; beside a figure the runs it is of, beside a number its interval."""
    rows = []
    for group, row in zip(groups, cells, strict=True):
        entry: dict[str, Figure] = {**group.settings, "runs": len(group.runs)}
        for name, cell in row.items():
            if isinstance(cell, Estimate):
                entry |= _columns(name, cell)
                entry |= {} if cell.larger is None else _columns(f"{name} larger", cell.larger)
            else:
                entry[name] = _cell(cell)
            entry[f"{name} runs"] = known_in(cell)
        rows.append(entry)
    return rows_csv(rows)


def _columns(name: str, found: Interval) -> dict[str, float]:
    return {name: found.value, f"{name} low": found.low, f"{name} high": found.high}
