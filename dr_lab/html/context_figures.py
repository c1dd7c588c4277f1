"""Learned distributions of contexts: at the beginning, in the end, and on the way."""

from collections.abc import Mapping, Sequence

import numpy as np
import plotly.graph_objects as go

from dr_lab.html.figure import AFTER, NOISE, Plot, chart, line, numbers, series, soft
from dr_lab.html.target_figures import spread_plot
from dr_lab.html.thinning import spread
from dr_lab.recorders.distributions import CONTENTS, ellipse
from dr_lab.recorders.training import Marginal, Pair, Spread
from dr_lab.reports.quantity import percent, titled
from dr_lab.trajectory import Array

_TIMES, _LEAST = 120, 10  # columns of a picture over iterations, at most and at least
_CELLS = 250_000  # of all pictures together, about 1.3 MB
_PAIRS = 28  # ellipses of 8 parameters; the recording has all
_HEIGHT = 280  # px
DENSITY = [[0.0, "var(--low)"], [0.5, "var(--middle)"], [1.0, "var(--high)"]]


def marginal_plots(marginals: Sequence[Marginal], spreads: Sequence[Spread] = ()) -> list[Plot]:
    """Each parameter's density at the beginning and in the end and, where it changed, its course between.

    Args:
        marginals: the densities.
        spreads: of those of them whose course mean and standard deviation tell better.
    """
    gaussian = {each.name: spread_plot(each) for each in spreads}
    bins = sum(each.probability.shape[1] for each in marginals)
    times = max(_LEAST, min(_TIMES, _CELLS // max(bins, 1)))
    courses = [[gaussian[each.name]] if each.name in gaussian else _course(each, times) for each in marginals]
    return [plot for each, course in zip(marginals, courses, strict=True) for plot in (_ends(each), *course)]


def pair_plots(pairs: Sequence[Pair]) -> list[Plot]:
    """Ellipses of the first pairs of parameters in the end, those of the beginning, and the way of the mean."""
    left = f" {len(pairs) - _PAIRS} more pairs are in review.rrd." if len(pairs) > _PAIRS else ""
    shown = pairs[:_PAIRS]
    return [_pair(pair, left if pair is shown[-1] else "") for pair in shown]


def group_marginal_plots(learned: Mapping[str, Mapping[str, Marginal]], groups: Sequence[str]) -> list[Plot]:
    """By parameter, what each group learnt, over what the first began with.

    Args:
        learned: by parameter and group.
        groups: in the order of their colours.
    """
    plots = []
    for each in learned.values():
        first = next(iter(each.values()))
        figure = chart()
        figure.add_trace(_density(first, first.initial, "initial", NOISE))
        for group, marginal in each.items():
            figure.add_trace(_density(marginal, marginal.probability[-1], group, series(groups.index(group))))
        plots.append(Plot(_with_axes(figure, first), _HEIGHT, half=len(learned) > 1))
    return plots


def _ends(marginal: Marginal) -> Plot:
    figure = chart()
    figure.add_trace(_density(marginal, marginal.initial, "initial", NOISE if marginal.learned else AFTER))
    figure.update_layout(showlegend=marginal.learned)
    if marginal.learned:
        figure.add_trace(_density(marginal, marginal.probability[-1], "learned", AFTER))
    return Plot(_with_axes(figure, marginal), _HEIGHT, half=True)


def _with_axes(figure: go.Figure, marginal: Marginal) -> go.Figure:
    figure.update_xaxes(title=marginal.title)
    return figure.update_yaxes(title=titled("density", _inverse(marginal.unit)), rangemode="tozero")


def _inverse(unit: str) -> str:
    return "" if unit in ("", "1") else f"1/({unit})" if "·" in unit or "/" in unit else f"1/{unit}"


def _density(marginal: Marginal, probability: Array, name: str, colour: str) -> go.Scatter:
    """Outline of the histogram, from the axis and back to it."""
    density = probability / np.diff(marginal.edges)
    x, y = np.repeat(marginal.edges, 2), np.concatenate([[0.0], np.repeat(density, 2), [0.0]])
    fill = {"fill": "tozeroy", "fillcolor": soft(colour)}
    return go.Scatter(x=numbers(x), y=numbers(y), name=name, showlegend=True, **line(colour, 2.0), **fill)


def _course(marginal: Marginal, times: int) -> list[Plot]:
    """The density over iterations; nothing where it never changed."""
    if len(marginal.iteration) < 2:
        return []
    kept = spread(len(marginal.iteration), times)
    density = marginal.probability[kept] / np.diff(marginal.edges)
    middle = (marginal.edges[1:] + marginal.edges[:-1]) / 2
    bar = {"title": {"text": "density", "side": "right"}, "thickness": 12}
    figure = chart()
    figure.add_trace(
        go.Heatmap(x=marginal.iteration[kept], y=middle, z=numbers(density.T), colorscale=DENSITY, colorbar=bar)
    )
    figure.update_xaxes(title="iteration", showgrid=False)
    figure.update_yaxes(title=marginal.title, showgrid=False)
    return [Plot(figure, _HEIGHT, half=True)]


def _pair(pair: Pair, left: str) -> Plot:
    figure, kept = chart(), spread(len(pair.iteration), _TIMES)
    figure.add_trace(go.Scatter(x=pair.mean[kept, 0], y=pair.mean[kept, 1], name="way of the mean", **line(NOISE, 1.0)))
    for index, content in enumerate(CONTENTS):
        for at, name, colour in ((0, "initial", NOISE), (-1, "learned", AFTER)):
            x, y = ellipse(pair.mean[at], pair.covariance[at], content)
            said = {"name": name, "legendgroup": name, "showlegend": index == 0}
            figure.add_trace(go.Scatter(x=numbers(x), y=numbers(y), **said, **line(colour, 2.0 - 0.5 * index)))
    titles = [titled(name, unit) for name, unit in zip(pair.names, pair.units, strict=True)]
    figure.update_xaxes(title=titles[0], range=[pair.low[0], pair.high[0]])
    figure.update_yaxes(title=titles[1], range=[pair.low[1], pair.high[1]])
    caption = f"Ellipses hold {', '.join(map(percent, CONTENTS))}.{left}"
    return Plot(figure, 360, caption, half=True)
