"""What models miss at a joint, against what it may be a function of: friction shows as a step or a slope."""

import numpy as np
import plotly.graph_objects as go

from dr_lab.html.figure import ROLES, Plot, chart, numbers
from dr_lab.html.return_figures import ABOUT_ZERO
from dr_lab.recorders.force_map import ForceMap
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import MEASURED, SIMULATED, Overlay
from dr_lab.recorders.scatter import bin_means
from dr_lab.reports.quantity import titled
from dr_lab.trajectory import Array

_COLUMNS = 3  # plots side by side
_MAP = 340  # px
_ELSE = "What else it depends on is as in the nearest of these states."
_DRAWN = "Dots: a short window each; lines: their mean over ranges that hold as many dots each."
_INSIDE = 99.5  # % of the dots that the axis holds, so that one does not flatten the others


def force_plots(overlay: Overlay, look: Look) -> list[Plot]:
    """One figure a joint: dots, and their mean over equally filled ranges."""
    drawn = [_joint(overlay, joint, look) for joint in overlay.joints() if overlay.arguments.get(joint)]
    return [*drawn, *(_map(joint, each, look) for joint, each in overlay.force_maps.items())]


def _joint(overlay: Overlay, joint: str, look: Look) -> Plot:
    residuals = overlay.residual_velocity[joint][1]
    arguments = overlay.arguments[joint]
    lines = -(-len(arguments) // _COLUMNS)
    figure = chart(lines, min(_COLUMNS, len(arguments)), shared_yaxes=True, horizontal_spacing=0.03)
    for index, (title, value) in enumerate(arguments.items()):
        row, col = index // _COLUMNS + 1, index % _COLUMNS + 1
        for role in [role for role in SIMULATED if role in residuals]:
            for trace in _traces(value, residuals[role], role, overlay.label(role), look):
                figure.add_trace(trace.update(showlegend=trace.showlegend and index == 0), row=row, col=col)
        if joint in overlay.learned:
            figure.add_trace(_learned(value, overlay.learned[joint], look, named=index == 0), row=row, col=col)
        figure.update_xaxes(title=title, row=row, col=col)
    reach = _reach(np.concatenate([*residuals.values()]))
    figure.update_yaxes(range=[-reach, reach], zeroline=True)
    figure.update_yaxes(title=f"{joint}: {overlay.residual_name(joint)}", col=1)
    return Plot(figure, 110 + 230 * lines, _DRAWN)


def _traces(value: Array, residual: Array, role: str, label: str, look: Look) -> list[go.Scatter]:
    known = np.flatnonzero(np.isfinite(value) & np.isfinite(residual))
    kept = known[:: max(1, -(-len(known) // look.scatter_points))]
    dots = {"mode": "markers", "marker": {"color": ROLES[role], "size": 5, "opacity": 0.55}, "legendgroup": role}
    means = {"mode": "lines", "line": {"color": ROLES[role], "width": 2.5}, "legendgroup": role, "hoverinfo": "skip"}
    x, y = bin_means(value, residual, look.scatter_bins)
    return [
        go.Scatter(x=numbers(value[kept]), y=numbers(residual[kept]), name=label, showlegend=True, **dots),
        go.Scatter(x=numbers(x), y=numbers(y), name=label, showlegend=False, **means),
    ]


def _learned(value: Array, force: Array, look: Look, *, named: bool) -> go.Scatter:
    """The mean of a learned force, which is what it makes of the model before it."""
    x, y = bin_means(value, force, look.scatter_bins)
    line = {"color": ROLES[MEASURED], "width": 2.5, "dash": "dash"}
    style = {"mode": "lines", "line": line, "legendgroup": "learned", "hoverinfo": "skip"}
    return go.Scatter(x=numbers(x), y=numbers(y), name="learned force", showlegend=named, **style)


def _map(joint: str, shown: ForceMap, look: Look) -> Plot:
    """A learned force over position and velocity; what no log shows stays empty."""
    bar = {"title": {"text": titled("learned force", shown.unit), "side": "right"}, "thickness": 12}
    scale = {"colorscale": ABOUT_ZERO, "zmin": -shown.reach(), "zmax": shown.reach(), "colorbar": bar}
    said = "position %{x:.4g}, velocity %{y:.4g}: %{z:.3g}<extra></extra>"
    figure = chart()
    grid = {"x": shown.position.values, "y": shown.velocity.values, "z": numbers(shown.force.T)}
    figure.add_trace(go.Heatmap(**grid, name="learned force", hovertemplate=said, **scale))
    place = shown.places(look.scatter_points)
    dots = {"mode": "markers", "marker": {"color": ROLES[MEASURED], "size": 3}, "hoverinfo": "skip"}
    figure.add_trace(go.Scatter(x=numbers(place[:, 0]), y=numbers(place[:, 1]), name="the log", **dots))
    figure.update_layout(showlegend=False)
    figure.update_xaxes(title=titled(shown.position.name, shown.position.unit), showgrid=False)
    figure.update_yaxes(title=titled(shown.velocity.name, shown.velocity.unit), showgrid=False)
    told = f"Force learned at {joint}; dots: where the log was, blank: where no log was. {_ELSE}"
    return Plot(figure, _MAP, told, half=True)


def _reach(value: Array) -> float:
    finite = np.abs(value[np.isfinite(value)])
    return 1.05 * float(np.percentile(finite, _INSIDE)) if len(finite) and finite.max() > 0 else 1.0
