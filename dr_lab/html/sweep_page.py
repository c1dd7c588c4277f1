"""`report.html` of summarize: the comparison first, then what its runs learnt and earned."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import plotly.graph_objects as go

from dr_lab.html.context_figures import group_marginal_plots
from dr_lab.html.curve_figures import band_plots
from dr_lab.html.document import Chapter, Text, write_document
from dr_lab.html.figure import Plot, chart, rows_height, series
from dr_lab.html.interference_figures import interference_plots
from dr_lab.html.return_figures import grid_lines, grid_maps, sample_plots
from dr_lab.html.sampling_figures import sampling_plots
from dr_lab.recorders.sweep_review import SweepRecord
from dr_lab.reports.page import Page, Section
from dr_lab.reports.plain import Number
from dr_lab.reports.quantity import counted, titled
from dr_lab.reports.summarize import GroupEntry, SummarizeReport

_UNTOLD = ("seconds",)  # figures that compare machines rather than methods come last
_UNTITLED = {"figures": "Table", "notes": "Notes"}  # sections that report.md gives no heading
_PLOTS, _COLUMNS = 10, 3  # of figures, the others are in the table; and side by side at most
_LINE, _APART = 140, 3  # letters that the page is wide, and between two titles
_COMMON = "figures."  # path of all figures of an evaluation


def write_sweep_page(path: Path, page: Page, report: SummarizeReport, record: SweepRecord) -> None:
    """Write the page, atomically: what `report.md` says, with plots of what the recording holds.

    Args:
        path: the file, by custom ``report.html``.
        page: what is said.
        report: the groups' figures.
        record: what is drawn; its first groups are those of the report.

    Raises:
        DrLabError: the folder cannot be written to.
    """
    lines = [grid_lines(each, record.groups) for each in record.lines.values()]
    maps = grid_maps(list(record.maps.values()))
    colours = {group: series(index) for index, group in enumerate(record.groups)}
    scattered = [(sample, colours[group]) for group, samples in record.violins.items() for sample in samples]
    chapters = [
        Chapter("Comparison", comparison_plots(report.groups, record.groups, report.units)),
        *_told(page.sections, record),
        Chapter("Over training", band_plots(record.bands, record.groups)),
        Chapter("Learned distributions", group_marginal_plots(record.marginals, record.groups)),
        Chapter("Returns over contexts", [*lines, *maps]),
        Chapter("Returns", sample_plots([sample for sample, _ in scattered], [colour for _, colour in scattered])),
        *(Chapter(title, [Text(text)]) for title, text in record.pages.items() if title == "Runs"),
    ]
    write_document(path, page.title, page.lead, chapters)


def _told(sections: Sequence[Section], record: SweepRecord) -> list[Chapter]:
    """What is said, below what is drawn of the same."""
    drawn = {"sampling": sampling_plots(record.sampled), "interference": interference_plots(record.interference)}
    return [Chapter(s.title or _UNTITLED[s.key], [*drawn.get(s.key, []), Text(s.body)]) for s in sections if s.body]


def comparison_plots(groups: Sequence[GroupEntry], labels: Sequence[str], units: Mapping[str, str]) -> list[Plot]:
    """Each figure's interquartile mean with its interval, a row a group; figures that do not differ are left out.

    Args:
        groups: with their figures.
        labels: of the groups, in their order.
        units: of figures that have one, by path.
    """
    names = dict.fromkeys(name for group in groups for name, value in group.figures.items() if "iqm" in value)
    differing = [name for name in names if len({group.figures.get(name, {}).get("iqm") for group in groups}) > 1]
    ordered = sorted(differing, key=lambda name: name in _UNTOLD)
    if not ordered:
        return []
    titles = {name: titled(name.removeprefix(_COMMON), units.get(name, "")) for name in ordered}
    first, others = ordered[:1], ordered[1:_PLOTS]
    columns = _columns([titles[name] for name in others], labels)
    rows = [first, *(others[at : at + columns] for at in range(0, len(others), columns))]
    told = [
        "Interquartile means with their intervals, which a group of fewer than three runs has not.",
        *[""] * (len(rows) - 1),
    ]
    return [
        _row({name: titles[name] for name in names}, groups, labels, caption)
        for names, caption in zip(rows, told, strict=True)
    ]


def _columns(titles: Sequence[str], labels: Sequence[str]) -> int:
    """How many figures stand side by side so that their titles, below the axes, do not run into one another."""
    widest = max(map(len, titles), default=0) + _APART
    room = _LINE - max(map(len, labels), default=0)
    return max(1, min(_COLUMNS, room // widest))


def _row(titles: Mapping[str, str], groups: Sequence[GroupEntry], labels: Sequence[str], caption: str) -> Plot:
    """Some figures side by side, by path with their titles, whose rows have their labels once."""
    figure = chart(1, len(titles), shared_yaxes=True, horizontal_spacing=0.03)
    for column, (name, title) in enumerate(titles.items(), start=1):
        for index, (group, label) in enumerate(zip(groups, labels, strict=False)):
            if group.figures.get(name, {}).get("iqm") is not None:
                figure.add_trace(_estimate(group.figures[name], label, series(index)), row=1, col=column)
        figure.update_xaxes(title=title, nticks=5, tickangle=0, row=1, col=column)
    figure.update_yaxes(categoryorder="array", categoryarray=[*labels[: len(groups)]][::-1])
    return Plot(figure, rows_height(len(groups)), caption)


def _estimate(found: Mapping[str, Number], label: str, colour: str) -> go.Scatter:
    value = found["iqm"] or 0.0
    low, high = (found.get(end) for end in ("low", "high"))
    ends = {"array": [0.0 if high is None else high - value], "arrayminus": [0.0 if low is None else value - low]}
    error = {"type": "data", "symmetric": False, "thickness": 3, "width": 6, **ends}
    runs = counted(int(found.get("runs") or 0), "run")
    look = {"mode": "markers", "marker": {"color": colour, "size": 11}, "showlegend": False}
    return go.Scatter(x=[value], y=[label], error_x=error, text=[runs], name=label, **look)
