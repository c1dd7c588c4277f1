"""How often contexts of each kind were drawn as training went on: a map a group, side by side."""

from collections.abc import Mapping, Sequence

import plotly.graph_objects as go

from dr_lab.html.context_figures import DENSITY
from dr_lab.html.figure import Plot, chart, headed, numbers
from dr_lab.recorders.sampling import Sampled, highest_share
from dr_lab.reports.quantity import percent, titled

_HEIGHT = 340  # px


def sampling_plots(sampled: Mapping[str, Sequence[Sampled]]) -> list[Plot]:
    """By parameter and group, the share of each block's draws by bin; one scale of colours for a parameter."""
    return [
        _map(each, max(map(highest_share, of_parameter)), half=len(of_parameter) > 1)
        for of_parameter in sampled.values()
        for each in of_parameter
    ]


def _map(sampled: Sampled, highest: float, half: bool) -> Plot:
    bar = {"title": {"text": "share of draws", "side": "right"}, "thickness": 12, "tickformat": ".0%"}
    look = {"colorscale": DENSITY, "zmin": 0.0, "zmax": highest, "colorbar": bar, "customdata": sampled.count.T}
    said = "%{x:,.0f} steps, %{y:.4g}: %{z:.1%}, %{customdata} draws<extra></extra>"
    shape = {"x": sampled.frames, "y": sampled.edges, "z": numbers(sampled.share.T)}
    figure = headed(chart(), sampled.group, sampled.told)
    figure.add_trace(go.Heatmap(**shape, name=sampled.group, hovertemplate=said, **look))
    figure.update_xaxes(title="control steps", showgrid=False, exponentformat="SI", nticks=6)
    figure.update_yaxes(title=titled(sampled.name, sampled.unit), showgrid=False)
    block = int(sampled.frames[1] - sampled.frames[0])
    drawn, uniform = int(sampled.count.sum()), percent(1.0 / sampled.count.shape[1])
    told = f"{sampled.group}: {drawn} draws of {sampled.told} together, by blocks of {block} control steps."
    return Plot(figure, _HEIGHT, f"{told} Uniform would be {uniform} a bin.", half=half)
