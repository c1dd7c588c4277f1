"""The tables of a sweep: Markdown to be read, CSV to be worked with."""

from collections.abc import Mapping, Sequence

from dr_lab.reports.csv_rows import rows_csv
from dr_lab.reports.quantity import number
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


def summary_page(
    sweep: str,
    groups: Sequence[Group],
    cells: Sequence[Cells],
    shared: Mapping[str, Figure],
    notes: Sequence[str],
    statistics: Statistics,
) -> str:
    """What differs between groups, and their figures; those that all runs share, in one sentence.

    Args:
        sweep: its name.
        groups: of runs.
        cells: the figures of each.
        shared: figures that are the same in every run.
        notes: sentences for its end.
        statistics: how the runs of a group were summed up.
    """
    keys = list(groups[0].settings)
    rows = [
        [name, *(group.settings[key] for key in keys), _runs(row[name], len(group.runs)), _cell(row[name])]
        for name in dict.fromkeys(name for row in cells for name in row)
        if name not in shared
        for group, row in zip(groups, cells, strict=True)
        if name in row
    ]
    alike = ", ".join(f"{name} {value if isinstance(value, str) else number(value)}" for name, value in shared.items())
    told = [f"The same in all runs: {alike}."] if shared else []
    count = sum(len(group.runs) for group in groups)
    lines = [
        f"# {count} runs of {sweep}",
        "",
        f"Interquartile means over the runs of a row, with {100 * statistics.confidence:g} % bootstrap intervals.",
        "",
        table(["figure", *keys, "runs", "mean (interval)"], rows),
    ]
    return "\n\n".join(["\n".join(lines), *told, *notes]) + "\n"


def _runs(cell: Cell, members: int) -> str:
    """Of how many runs of a group a figure is."""
    known = known_in(cell)
    return str(members) if known == members else f"{known} of {members}"


def _cell(cell: Cell) -> str:
    if not isinstance(cell, Estimate):
        return ", ".join(f"{word} ({count})" for word, count in cell.items())
    if cell.low != cell.low:  # one run has no interval
        return number(cell.value)
    return f"{number(cell.value)} ({number(cell.low)} … {number(cell.high)})"


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


def runs_page(runs: Sequence[Run], figures: Mapping[str, Sequence[str]]) -> str:
    """Every run with what differs, as Markdown."""
    rows = _runs_table(runs, figures)
    cells = [[value if isinstance(value, str) else number(value) for value in row.values()] for row in rows]
    return table(list(rows[0]), cells) + "\n"


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
                entry |= {name: cell.value, f"{name} low": cell.low, f"{name} high": cell.high}
            else:
                entry[name] = _cell(cell)
            entry[f"{name} runs"] = known_in(cell)
        rows.append(entry)
    return rows_csv(rows)
