"""What evaluations show: returns over contexts, gains, gradients, ways, and how returns scatter."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from dr_lab.html.context_figures import DENSITY
from dr_lab.html.figure import AFTER, BEFORE, INK, MEASURED, MUTED, Plot, band, chart, line, numbers, series, soft
from dr_lab.recorders.training import ContextAxis, Gain, Grid, Matrix, Sample, Ways, over_what
from dr_lab.reports.quantity import titled
from dr_lab.trajectory import Array

_MAP, _LINE = 420, 320  # px
_HATCHES = 3  # lines across a cell without a value
_SCATTER = 4.0  # standard deviations within a cell
_TICKS = 9  # values of an axis, each of which has room for its number
ABOUT_ZERO = [[0.0, BEFORE], [0.5, "var(--low)"], [1.0, AFTER]]
_INFEASIBLE = "infeasible"
_VIOLIN = "Dots: these values; box: quartiles and median; dashed: mean; outline: how dense they lie."


def grid_plots(grids: Sequence[Grid]) -> list[Plot]:
    """Returns over two parameters as a map each, over the same one as lines of one plot."""
    lines: dict[str, dict[str, Grid]] = {}
    for grid in grids:
        if len(grid.axes) == 1:
            lines.setdefault(grid.axes[0].name, {})[grid.title] = grid
    maps = grid_maps([grid for grid in grids if len(grid.axes) == 2])
    return maps + [grid_lines(each, list(each)) for each in lines.values()]


def grid_lines(grids: Mapping[str, Grid], groups: Sequence[str]) -> Plot:
    """Returns over one parameter, of several groups in one plot.

    Args:
        grids: over the same parameter, by group.
        groups: in the order of their colours.
    """
    figure = chart()
    for group, grid in grids.items():
        colour, x = series(groups.index(group)), grid.axes[0].values
        known = np.isfinite(grid.mean)
        edges = grid.mean - grid.spread, grid.mean + grid.spread
        figure.add_trace(band(x, *edges, colour, showlegend=False, legendgroup=group))
        look = {"mode": "lines+markers", "line": {"color": colour, "width": 2}, "legendgroup": group}
        figure.add_trace(go.Scatter(x=x[known], y=numbers(grid.mean[known]), name=group, showlegend=True, **look))
        for index in np.flatnonzero(~known).tolist():
            figure.add_vrect(*_cell(x, index), fillcolor=MUTED, opacity=0.15, line_width=0)
    first = next(iter(grids.values()))
    figure.update_xaxes(**_axis(first.axes[0]))
    figure.update_yaxes(title="return")
    unknown = any(not np.isfinite(grid.mean).all() for grid in grids.values())
    told = f"Bands: ± a standard deviation over {over_what(list(grids.values()))}."
    return Plot(figure, _LINE, told + " Grey: infeasible." * unknown)


def grid_maps(grids: Sequence[Grid]) -> list[Plot]:
    """Mean returns over two parameters each; maps over the same ones share their colours, so that they compare."""
    alike: dict[tuple[str, ...], list[Grid]] = {}
    for grid in grids:
        alike.setdefault(_parameters(grid), []).append(grid)
    return [_grid_map(grid, alike[_parameters(grid)]) for grid in grids]


def _parameters(grid: Grid) -> tuple[str, ...]:
    return tuple(axis.name for axis in grid.axes)


def _grid_map(grid: Grid, alike: Sequence[Grid]) -> Plot:
    more = {"customdata": numbers(grid.spread.T), **_beyond_scatter(alike)}
    figure = _map(grid.axes, grid.mean, DENSITY, "return", more)
    figure.update_traces(hovertemplate="%{x:.4g}, %{y:.4g}: %{z:.4g} ± %{customdata:.3g}<extra></extra>", selector=0)
    told = f"Colours span four standard deviations over {over_what(alike)} in a cell, or more"
    same = ", and are the same in all maps over these parameters" if len(alike) > 1 else ""
    return Plot(figure, _MAP, f"Mean returns, {grid.title}. {told}{same}.{hatched(grid.mean)}", half=True)


def _beyond_scatter(grids: Sequence[Grid]) -> dict[str, float]:
    """Ends of the colours that hold all means, and so far apart that the scatter within a cell is no pattern."""
    mean = np.concatenate([grid.mean.ravel() for grid in grids])
    spread = np.concatenate([grid.spread.ravel() for grid in grids])
    known = np.isfinite(mean)
    if not known.any():
        return {}
    low, high = float(mean[known].min()), float(mean[known].max())
    half = max((high - low) / 2, _SCATTER / 2 * float(np.median(spread[known])))
    return {"zmin": (low + high) / 2 - half, "zmax": (low + high) / 2 + half}


def gain_plots(gains: Sequence[Gain]) -> list[Plot]:
    """What updates add to the return; where its sign is in doubt is marked by a dot."""
    return [_gain_map(gain) if len(gain.axes) == 2 else _gain_line(gain) for gain in gains]


def matrix_plots(matrices: Sequence[Matrix]) -> list[Plot]:
    """Cosines between the gradients of contexts; where the sign is in doubt is marked by a dot."""
    plots = []
    for each in matrices:
        figure = _map([each.axis, each.axis], each.value, ABOUT_ZERO, "cosine", {"zmin": -1.0, "zmax": 1.0})
        figure.add_trace(dots([each.axis, each.axis], each.doubtful & np.isfinite(each.value)))
        plots.append(Plot(figure, _MAP, f"{each.title}. Dots: the sign is in doubt.{_untold(each)}", half=True))
    return plots


def _untold(matrix: Matrix) -> str:
    return "" if np.isfinite(matrix.value).all() else " Hatched: infeasible, or no gradient that is told from noise."


def ways_plots(ways: Sequence[Ways]) -> list[Plot]:
    """Ways in the plane before and after updates, to the goals."""
    plots = []
    for each in ways:
        figure = chart()
        for name, colour, courses in (("before", BEFORE, each.before), ("after", AFTER, each.after)):
            # One trace, for its legend hides all: a NaN parts one course from the next.
            points = [np.vstack([course, [[np.nan, np.nan]]]) for course in courses]
            x, y = np.concatenate([*points, np.empty((0, 2))]).T
            figure.add_trace(go.Scatter(x=numbers(x), y=numbers(y), name=name, **line(colour, 1.5)))
        marker = {"color": MEASURED, "size": 12, "symbol": "circle-open", "line": {"width": 2}}
        goal = {"mode": "markers", "marker": marker, "name": "goals"}
        figure.add_trace(go.Scatter(x=each.goals[:, 0], y=each.goals[:, 1], **goal))
        reach = 2.0 * float(np.abs(each.goals).max(initial=0.5))
        figure.update_xaxes(title="x [m]", range=[-reach, reach])
        figure.update_yaxes(title="y [m]", range=[-reach, reach], scaleanchor="x")
        plots.append(Plot(figure, _MAP, f"Ways, {each.title}.", half=True))
    return plots


def sample_plots(samples: Sequence[Sample], colours: Sequence[str] = ()) -> list[Plot]:
    """How values scatter: a violin each, with quartiles, mean and every value; infeasible ones are left out.

    Args:
        samples: the values.
        colours: one each; by default one after the other of those that groups have.
    """
    known = [(each, each.value[np.isfinite(each.value)]) for each in samples]
    if not any(len(values) for _, values in known):
        return []
    figure = chart()
    for index, (each, values) in enumerate(known):
        colour = colours[index] if colours else series(index)
        style = {"line": {"color": colour, "width": 1.5}, "fillcolor": soft(colour), "width": 0.6, "spanmode": "hard"}
        inside = {"meanline": {"visible": True}, "box": {"visible": True, "fillcolor": "rgba(0,0,0,0)", "width": 0.15}}
        dots = {"points": "all", "pointpos": 0, "jitter": 0.5, "marker": {"size": 4, "opacity": 0.5, "color": INK}}
        figure.add_trace(go.Violin(y=numbers(values), name=each.name, **style, **inside, **dots))
    figure.update_layout(showlegend=False)
    figure.update_yaxes(title="return", zeroline=False)
    return [Plot(figure, _MAP, f"{samples[0].told} {_VIOLIN}".lstrip())]


def _gain_map(gain: Gain) -> Plot:
    known = np.abs(gain.value[np.isfinite(gain.value)])
    reach = float(known.max()) if len(known) and known.max() > 0.0 else 1.0
    figure = _map(gain.axes, gain.value, ABOUT_ZERO, "gain", {"zmin": -reach, "zmax": reach})
    figure.add_trace(dots(gain.axes, gain.doubtful & np.isfinite(gain.value)))
    return Plot(figure, _MAP, f"Gain {gain.title}. Dots: the sign is in doubt.{hatched(gain.value)}", half=True)


def _gain_line(gain: Gain) -> Plot:
    x, known = gain.axes[0].values, np.isfinite(gain.value)
    figure = chart()
    figure.add_trace(band(x, gain.low, gain.high, AFTER, name="interval", showlegend=True))
    look = {"mode": "lines+markers", "line": {"color": AFTER, "width": 2}}
    figure.add_trace(go.Scatter(x=x[known], y=numbers(gain.value[known]), name="mean", **look))
    figure.add_hline(0.0, line={"color": INK, "width": 1})
    figure.update_xaxes(**_axis(gain.axes[0]))
    figure.update_yaxes(title="gain")
    return Plot(figure, _LINE, f"Gain {gain.title}.", half=True)


def _map(
    axes: Sequence[ContextAxis], value: Array, colours: Sequence[object], name: str, more: Mapping[str, object]
) -> go.Figure:
    """A heat map, shape (n, m) as the axes; cells without a value are hatched."""
    across, up = axes
    bar = {"title": {"text": name, "side": "right"}, "thickness": 12}
    figure = chart()
    shape = {"x": across.values, "y": up.values, "z": numbers(value.T), "colorscale": colours, "colorbar": bar}
    figure.add_trace(go.Heatmap(**shape, **more))
    figure.add_trace(hatching(across.values, up.values, ~np.isfinite(value)))
    figure.update_xaxes(**_axis(across), showgrid=False, zeroline=False)
    figure.update_yaxes(**_axis(up), showgrid=False, zeroline=False)
    return figure


def hatching(x: Array, y: Array, unknown: NDArray[np.bool_]) -> go.Scatter:
    """Slanting lines across the cells without a value, as one trace with gaps."""
    share = np.arange(1, 2 * _HATCHES) / _HATCHES  # of the way along the lower and the right edge
    lines: list[tuple[float | None, float | None]] = []
    for i, j in np.argwhere(unknown).tolist():
        (left, right), (bottom, top) = _cell(x, i), _cell(y, j)
        for at in share:
            begin, end = (max(0.0, at - 1.0), min(at, 1.0)), (min(at, 1.0), max(0.0, at - 1.0))
            for u, v in (begin, end):
                lines.append((left + u * (right - left), bottom + v * (top - bottom)))
            lines.append((None, None))
    style = {"mode": "lines", "line": {"color": MUTED, "width": 1}, "hoverinfo": "skip", "name": _INFEASIBLE}
    return go.Scatter(x=[u for u, _ in lines], y=[v for _, v in lines], showlegend=False, **style)


def _cell(values: Array, index: int) -> tuple[float, float]:
    """The ends of the cell about a value: half-way to its neighbours, as far on the other side where it has none."""
    steps = np.diff(values) / 2 if len(values) > 1 else np.array([0.5])
    below, above = steps[max(index - 1, 0)], steps[min(index, len(steps) - 1)]
    return float(values[index] - below), float(values[index] + above)


def dots(axes: Sequence[ContextAxis], where: NDArray[np.bool_]) -> go.Scatter:
    """A dot in each cell of a map, shape (n, m) as the axes, in which something is in doubt."""
    across, up = (axis.values[index] for axis, index in zip(axes, np.argwhere(where).T, strict=True))
    style = {"mode": "markers", "marker": {"color": INK, "size": 5}, "showlegend": False, "hoverinfo": "skip"}
    return go.Scatter(x=across, y=up, **style)


def hatched(value: Array) -> str:
    """What a caption says of cells without a value."""
    return "" if np.isfinite(value).all() else " Hatched: infeasible, no value."


def _axis(axis: ContextAxis) -> dict[str, Any]:
    """Its title, and where they are few, ticks at its values."""
    title: dict[str, Any] = {"title": titled(axis.name, axis.unit)}
    if len(axis.values) > _TICKS:
        return title
    return title | {"tickvals": axis.values, "ticktext": [f"{value:.3g}" for value in axis.values]}
