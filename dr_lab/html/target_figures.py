"""How a Gaussian over contexts draws near to a target: its spread, what it moves like, and how far off it still is."""

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go

from dr_lab.html.figure import AFTER, MEASURED, Plot, band, chart, line, numbers, series, whole_ticks
from dr_lab.html.thinning import spread, thinned
from dr_lab.recorders.training import Comparison, Comparisons, Decline, Spread
from dr_lab.reports.quantity import titled

_HEIGHT = 280  # px
_POINTS = 400  # of a curve
_FALLS = "Between target and model: before an iteration in the contexts drawn, after it at their mean."
_DECADES = 100.0  # largest over smallest, below which an axis has ticks at 1, 2 and 5
_FAINT = 0.7  # opacity of what was drawn


def spread_plot(each: Spread) -> Plot:
    """Mean and ± a standard deviation of one parameter over iterations."""
    figure, kept = chart(), spread(len(each.iteration), _POINTS)
    at, mean, std = each.iteration[kept], each.mean[kept], each.std[kept]
    figure.add_trace(band(at, mean - std, mean + std, AFTER, name="± std", showlegend=True))
    figure.add_trace(go.Scatter(x=at, y=numbers(mean), name="mean", **line(AFTER, 2.0)))
    figure.update_xaxes(title="iteration", **whole_ticks(float(at[-1])))
    figure.update_yaxes(title=titled(each.name, each.unit))
    return Plot(figure, _HEIGHT, half=True)


def comparison_plots(comparisons: Sequence[Comparisons]) -> list[Plot]:
    """Each quantity as the target moved and as the model moves, at the first and the last iteration."""
    return [_comparison(each) for each in comparisons if len(each.iteration)]


def decline_plots(declines: Sequence[Decline]) -> list[Plot]:
    """Figures that fall by orders of magnitude, on a logarithmic axis."""
    return [_decline(each) for each in declines]


def _comparison(each: Comparisons) -> Plot:
    ends = [0] if len(each.iteration) == 1 else [0, -1]
    titles = [f"iteration {each.iteration[end]}" for end in ends]
    figure = chart(1, len(ends), titles, shared_yaxes=True, horizontal_spacing=0.03)
    for column, end in enumerate(ends, start=1):
        for trace in _traces(each.shown[end], first=column == 1):
            figure.add_trace(trace, row=1, col=column)
    figure.update_xaxes(title="t [s]")
    figure.update_yaxes(title=titled(each.shown[0].name, each.shown[0].unit), col=1)
    return Plot(figure, _HEIGHT, "Thin lines: in contexts that were drawn.")


def _traces(shown: Comparison, first: bool) -> list[go.Scatter]:
    """The drawn ones below, as one trace with gaps, then the mean and the target."""
    gap = np.array([np.nan])
    thin = [thinned(shown.time, row, _POINTS) for row in shown.drawn]
    drawn = [(np.append(t, gap), np.append(v, gap)) for t, v in thin]
    x, y = (np.concatenate([gap, *parts]) for parts in zip(*drawn, strict=True)) if drawn else (gap, gap)
    faint = {"opacity": _FAINT, **line(AFTER, 1.0)}
    made = [go.Scatter(x=numbers(x), y=numbers(y), name="drawn", legendgroup="drawn", showlegend=first, **faint)]
    for name, value, colour in (("model at the mean", shown.mean, AFTER), ("target", shown.target, MEASURED)):
        t, v = thinned(shown.time, value, _POINTS)
        said = {"name": name, "legendgroup": name, "showlegend": first}
        made.append(go.Scatter(x=numbers(t), y=numbers(v), **said, **line(colour, 2.0)))
    return made


def _decline(decline: Decline) -> Plot:
    figure, kept = chart(), spread(len(decline.iteration), _POINTS)
    for index, (name, value) in enumerate(decline.values.items()):
        look = {"mode": "lines+markers", "line": {"color": series(index), "width": 2}, "marker": {"size": 5}}
        y = numbers(value[kept])
        figure.add_trace(go.Scatter(x=decline.iteration[kept], y=y, name=name, showlegend=True, **look))
    figure.update_xaxes(title="iteration", **whole_ticks(float(decline.iteration[-1])))
    known = np.concatenate([value[value > 0] for value in decline.values.values()])
    figure.update_yaxes(title=decline.name, type="log")
    if len(known) and known.max() < _DECADES * known.min():
        figure.update_yaxes(dtick="D2")  # those of all digits would overlap
    return Plot(figure, _HEIGHT, _FALLS, half=True)
