"""The ladder of models, and the error of its first one over the horizon."""

import numpy as np
import plotly.graph_objects as go

from dr_lab.html.figure import AFTER, BEFORE, INK, MUTED, NOISE, ROLES, Plot, chart, rows_height
from dr_lab.recorders.overlay import SIMULATED
from dr_lab.reports.gap import GapReport
from dr_lab.reports.ladder import before_after, steps
from dr_lab.reports.quantity import number, titled

_COLUMNS = 3  # plots side by side
_LABEL = 0.15  # room for a number behind the longest line, as a share of it


def ladder_plots(report: GapReport) -> list[Plot]:
    """χ² of each model on a logarithmic axis, from the noise floor; nothing of one model alone."""
    made = [step for step in steps(report) if step.held_out.chi2]
    if len(made) < 2:
        return []
    colours = {step.name: ROLES[role] for step, role in zip(before_after(report), SIMULATED, strict=False)}
    names, values = [step.name for step in made], [float(step.held_out.chi2 or 1.0) for step in made]
    figure = chart()
    for name, value in zip(names, values, strict=True):
        style = {"mode": "lines+markers+text", "cliponaxis": False, "textposition": "middle right", "showlegend": False}
        colour = colours.get(name, NOISE)
        look = {
            "line": {"color": colour, "width": 5},
            "marker": {"color": colour, "size": [0, 14], "opacity": 1, "line": {"width": 0}},
        }
        text = ["", f"  {number(value)}"]
        figure.add_trace(go.Scatter(x=[1.0, value], y=[name, name], text=text, hoverinfo="x+y", **style, **look))
    figure.add_vline(x=1.0, line={"color": INK, "dash": "dot", "width": 1})
    low, high = (np.log10(f([1.0, *values])) for f in (min, max))
    room = _LABEL * (high - low)
    figure.update_xaxes(title="χ² (1 = noise floor)", type="log", dtick=1, range=[low - 0.02 * room, high + room])
    figure.update_yaxes(autorange="reversed", showgrid=False)
    return [Plot(figure, rows_height(len(made)))]


def horizon_plots(report: GapReport) -> list[Plot]:
    """RMSE of each channel over the time predicted open loop."""
    rows = report.failing.horizons
    channels = list(dict.fromkeys(channel for row in rows for channel in row.rmse))
    if len(rows) < 2 or not channels:
        return []
    alone = len(report.ladder) == 1 and report.as_given is not None  # then the first model of the ladder is the last
    lines, colour = -(-len(channels) // _COLUMNS), AFTER if alone else BEFORE
    figure = chart(lines, min(_COLUMNS, len(channels)), channels)
    for index, channel in enumerate(channels):
        row, col = index // _COLUMNS + 1, index % _COLUMNS + 1
        x, y = [row.horizon for row in rows], [row.rmse.get(channel) for row in rows]
        look = {"line": {"color": colour}, "mode": "lines+markers"}
        figure.add_trace(go.Scatter(x=x, y=y, showlegend=False, **look), row=row, col=col)
        figure.update_xaxes(title="predicted for [s]", rangemode="tozero", row=row, col=col)
        unit = report.noise[channel].unit if channel in report.noise else ""
        figure.update_yaxes(title=titled("RMSE", unit), rangemode="tozero", row=row, col=col)
    figure.update_annotations(font={"color": MUTED})
    return [Plot(figure, 90 + 210 * lines)]
