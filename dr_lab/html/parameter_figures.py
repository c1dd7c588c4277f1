"""Parameters with their intervals, each on its own axis."""

from collections.abc import Mapping

import plotly.graph_objects as go

from dr_lab.html.figure import AFTER, MEASURED, NOISE, Plot, chart, rows_height
from dr_lab.reports.gap import GapReport
from dr_lab.reports.gap_entries import ParameterEntry, Parameters
from dr_lab.reports.quantity import titled, uncertain

_COLUMNS = 2
_ROW, _LABELS = 88, 62  # px of a parameter, and of them for ticks and the next title
_MOST = 24  # parameters of a figure, which is to fit on a page
_STDS = 2.0  # half-width of an interval


def parameter_plots(report: GapReport) -> list[Plot]:
    """The parameters of the last model without a learned force, beside the values given and those of each log alone."""
    fitted = [(name, row) for name, row in report.catalogued[-1].parameters.items() if row.value is not None]
    if report.catalogued[-1].fit is None:
        return []
    given = {} if report.as_given is None else report.as_given.parameters
    return [_plot(dict(fitted[start : start + _MOST]), given) for start in range(0, len(fitted), _MOST)]


def _plot(fitted: Parameters, given: Parameters) -> Plot:
    lines = -(-len(fitted) // _COLUMNS)
    titles = [titled(name, row.unit) for name, row in fitted.items()]
    figure = chart(lines, _COLUMNS, titles, vertical_spacing=_LABELS / (_ROW * lines), horizontal_spacing=0.08)
    for index, (name, entry) in enumerate(fitted.items()):
        row, col = index // _COLUMNS + 1, index % _COLUMNS + 1
        for trace in _traces(entry, given.get(name), first=index == 0):
            figure.add_trace(trace, row=row, col=col)
    figure.update_yaxes(visible=False, range=[-1.0, 1.0], fixedrange=True)
    figure.update_xaxes(nticks=5)
    figure.update_annotations(xanchor="center", font={"size": 12})
    caption = "Intervals are ±2 std; small dots are fits of one log alone."
    caption += " Diamonds: at a bound." * any(bool(entry.at_bound) for entry in fitted.values())
    return Plot(figure, rows_height(0) + _ROW * lines - _LABELS, caption)


def _traces(row: ParameterEntry, given: ParameterEntry | None, first: bool) -> list[go.Scatter]:
    per_log: Mapping[str, float | None] = {} if row.scatter is None else row.scatter.per_log
    logs = {log: value for log, value in per_log.items() if value is not None}
    spread = 0.0 if row.at_bound or row.std is None else _STDS * row.std
    said = uncertain(row.value, None if row.at_bound else row.std, row.unit) + (", at its bound" * bool(row.at_bound))
    style = {"mode": "markers", "showlegend": first}
    made = [
        go.Scatter(
            x=[*logs.values()], y=[-0.45] * len(logs), text=[*logs], hoverinfo="x+text", name="one log alone",
            legendgroup="log", marker={"color": NOISE, "size": 6, "opacity": 0.7}, **style,
        ),
        go.Scatter(
            x=[row.value], y=[0.2], text=[said], hoverinfo="text", name="fitted", legendgroup="fitted",
            error_x={"type": "data", "array": [spread], "thickness": 3, "width": 5},
            marker={"color": AFTER, "size": 11, "symbol": "diamond" if row.at_bound else "circle"}, **style,
        ),
    ]  # fmt: skip
    if given is not None and given.value is not None:
        marker = {"color": MEASURED, "symbol": "line-ns-open", "size": 16, "line": {"width": 2}}
        made.append(go.Scatter(x=[given.value], y=[0.2], name="as given", legendgroup="given", marker=marker, **style))
    return made
