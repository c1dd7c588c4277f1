"""Figures over training: one run's curves, several runs' bands, and the choice of the policy."""

import textwrap
from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go

from dr_lab.html.curve_meanings import meaning
from dr_lab.html.figure import AFTER, NOISE, Plot, band, chart, line, numbers, series, whole_ticks
from dr_lab.html.thinning import Numbers, spread, thinned
from dr_lab.recorders.training import Band, Curve
from dr_lab.reports.quantity import number, titled
from dr_lab.reports.train import ChoiceEntry
from dr_lab.trajectory import Array

_POINTS, _LEAST = 800, 40  # of a curve, at most and at least
_ALL, _LINES = 120_000, 5  # points of all bands together, about 2 MB; and columns of numbers of one
_SMOOTHED = 20  # parts of training, the width of the running mean
_FEW = 6  # points that are drawn as dots, too
_LARGE, _SMALL = 340, 230  # px
_TITLE = 26  # characters of a line beside a small plot
_COUNTED = {"iteration": "iteration", "frames": "control steps"}


def curve_plots(curves: Sequence[Curve]) -> list[Plot]:
    """The first curve large, the others two in a row."""
    return [_curve(curve, first=index == 0) for index, curve in enumerate(curves)]


def band_plots(bands: Sequence[Band], groups: Sequence[str]) -> list[Plot]:
    """One plot a figure, with the groups' interquartile means and intervals; the first is large.

    Args:
        bands: of every group and figure.
        groups: in the order of their colours.
    """
    points = max(_LEAST, min(_POINTS, _ALL // (_LINES * max(len(bands), 1))))
    figures: dict[str, list[Band]] = {}
    for each in bands:
        figures.setdefault(each.name, []).append(_sampled(each, points))
    return [_bands(name, each, groups, first=index == 0) for index, (name, each) in enumerate(figures.items())]


def choice_plots(choice: ChoiceEntry | None) -> list[Plot]:
    """Returns of the policies that were kept, with the one that is deployed; nothing where one alone was."""
    known = [] if choice is None else [each for each in choice.snapshots if each.mean_return is not None]
    if choice is None or len(known) < 2:
        return []
    figure, at = chart(), [each.frames for each in known]
    style = {"mode": "lines+markers", "line": {"color": NOISE, "width": 1}, "marker": {"size": 8}}
    figure.add_trace(go.Scatter(x=at, y=[each.mean_return for each in known], name="kept", **style))
    best = [each.mean_return for each in known if each.frames == choice.chosen]
    marker = {"color": AFTER, "size": 15, "symbol": "star"}
    figure.add_trace(go.Scatter(x=[choice.chosen], y=best, name="deployed", mode="markers", marker=marker))
    figure.update_xaxes(title="control steps", exponentformat="SI")
    figure.update_yaxes(title="mean return")
    return [Plot(figure, _SMALL, f"Chosen on {choice.choice_frames} control steps of episodes of its own.")]


def _curve(curve: Curve, first: bool) -> Plot:
    known = np.isfinite(curve.value)
    at, value = curve.at[known], curve.value[known]
    x, y = thinned(at, value, _POINTS)
    smooth = len(y) > 3 * _SMOOTHED
    figure = chart()
    mode = "lines+markers" if len(y) <= _FEW else "lines"
    look = {"mode": mode, "line": {"color": NOISE if smooth else AFTER, "width": 1 if smooth else 1.8}}
    figure.add_trace(go.Scatter(x=x, y=numbers(y), name="each iteration", showlegend=smooth and first, **look))
    if smooth:
        # Of all values: those that thinning keeps are the extremes, whose mean is another.
        middle, mean = _running_mean(at, value)
        kept = spread(len(mean), _POINTS)
        named = {"name": f"mean over 1/{_SMOOTHED} of the training", "showlegend": first}
        figure.add_trace(go.Scatter(x=middle[kept], y=numbers(mean[kept]), **line(AFTER, 2.5), **named))
    ticks = whole_ticks(float(curve.at.max(initial=0)))
    figure.update_xaxes(title=_COUNTED[curve.over], rangemode="tozero", exponentformat="SI", **ticks)
    figure.update_yaxes(title=_lines(titled(curve.name.replace("_", " "), curve.unit)))
    alone = f"One point alone: {number(float(y[0]))}." if len(y) == 1 else ""
    told = " ".join(filter(None, (meaning(curve.name), alone)))
    return Plot(figure, _LARGE if first else _SMALL, told, half=not first)


def _lines(title: str) -> str:
    """A title of an axis in lines that have room beside a small plot: its ends would be cut off."""
    return textwrap.fill(title, _TITLE)


def _running_mean(x: Numbers, y: Array) -> tuple[Array, Array]:
    """Mean over so many neighbouring points as a part of training has, at their middle."""
    width = max(1, len(y) // _SMOOTHED)
    sums = (np.cumsum(np.insert(each.astype(float), 0, 0.0)) for each in (x, y))
    at, mean = ((before[width:] - before[:-width]) / width for before in sums)
    return at, mean


def _sampled(band: Band, points: int) -> Band:
    """At most so many of its points, evenly spaced, the first and the last among them."""
    kept = spread(len(band.frames), points)
    low, value, high = (column[kept] for column in (band.low, band.value, band.high))
    return Band(band.group, band.name, band.frames[kept], value, low, high)


def _bands(name: str, bands: Sequence[Band], groups: Sequence[str], first: bool) -> Plot:
    figure = chart()
    for each in bands:
        colour = series(groups.index(each.group))
        common = {"legendgroup": each.group}
        figure.add_trace(band(each.frames, each.low, each.high, colour, showlegend=False, **common))
        known = np.isfinite(each.value)
        x, y = each.frames[known], each.value[known]
        mode = "lines+markers" if len(y) <= _FEW else "lines"
        look = {"mode": mode, "line": {"color": colour, "width": 2}}
        figure.add_trace(go.Scatter(x=x, y=numbers(y), name=each.group, showlegend=first, **look, **common))
    figure.update_xaxes(title="control steps", rangemode="tozero", exponentformat="SI")
    figure.update_yaxes(title=_lines(name.replace("_", " ")))
    told = "Interquartile mean over the runs of a group, with its interval where they are three or more."
    caption = filter(None, [meaning(name), told if first else "", *_alone(bands)])
    return Plot(figure, _LARGE if first else _SMALL, " ".join(caption), half=not first)


def _alone(bands: Sequence[Band]) -> list[str]:
    """A sentence on each group of which there is but one point."""
    known = [(each, np.isfinite(each.value)) for each in bands]
    return [
        f"{each.group}: one point alone, {number(float(each.value[where][0]))} after {each.frames[where][0]} steps."
        for each, where in known
        if where.sum() == 1
    ]
