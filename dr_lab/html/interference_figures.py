"""How the policy gradients of contexts agree: a row of maps a group, from its first policy to its last."""

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go

from dr_lab.html.figure import Plot, chart, headed, numbers
from dr_lab.html.return_figures import ABOUT_ZERO, dots, hatched, hatching
from dr_lab.recorders.interference import Interference
from dr_lab.reports.quantity import number, titled

_HEIGHT = 340  # px


def interference_plots(found: Sequence[Interference]) -> list[Plot]:
    """One figure a group; where each has but one policy, two stand side by side."""
    groups: dict[str, list[Interference]] = {}
    for each in found:
        groups.setdefault(each.group, []).append(each)
    columns = max(map(len, groups.values()), default=0)
    return [_row(each, columns) for each in groups.values()]


def _row(policies: Sequence[Interference], columns: int) -> Plot:
    """The policies of a group side by side, in as many columns as other groups have, the last one to the right."""
    first = columns - len(policies) + 1
    titles = [""] * (first - 1) + [f"after {each.frames} control steps" for each in policies]
    figure = chart(1, columns, titles, shared_yaxes=True, horizontal_spacing=0.025)
    for column, each in enumerate(policies, start=first):
        for trace in _traces(each):
            figure.add_trace(trace, row=1, col=column)
        title = titled(each.axis.name, each.axis.unit)
        figure.update_xaxes(title=title, nticks=5, tickangle=0, showgrid=False, zeroline=False, row=1, col=column)
    axis = policies[0].axis
    figure.update_yaxes(showgrid=False, zeroline=False)
    figure.update_yaxes(title=titled(axis.name, axis.unit), showticklabels=True, row=1, col=first)
    bar = {"title": {"text": "cosine", "side": "right"}, "thickness": 12}
    figure.update_layout(coloraxis={"colorscale": ABOUT_ZERO, "cmin": -1.0, "cmax": 1.0, "colorbar": bar})
    headed(figure, policies[0].group, policies[0].told)
    return Plot(figure, _HEIGHT, _caption(policies), half=columns == 1)


def _traces(found: Interference) -> list[go.Heatmap | go.Scatter]:
    values, axes = found.axis.values, [found.axis, found.axis]
    said = "%{x:.4g}, %{y:.4g}: %{z:.3f}"
    more = {"hovertemplate": f"{said}<extra></extra>"}
    if found.runs > 1:
        more = {"customdata": numbers(found.spread), "hovertemplate": f"{said} ± %{{customdata:.2f}}<extra></extra>"}
    shape = {"x": values, "y": values, "z": numbers(found.mean), "coloraxis": "coloraxis", "name": found.group}
    unknown = hatching(values, values, ~np.isfinite(found.mean))
    return [go.Heatmap(**shape, **more), unknown, dots(axes, found.doubtful & np.isfinite(found.mean))]


def _caption(policies: Sequence[Interference]) -> str:
    told = f"{policies[0].group}: cosines between policy gradients, mean of {policies[0].told}."
    spread = np.concatenate([each.spread.ravel() for each in policies])
    known = spread[np.isfinite(spread)]
    if len(known):
        told += f" Standard deviation over the runs {number(float(known.mean()), 2)}, mean of all cells."
    whole = np.concatenate([each.mean for each in policies])
    return f"{told} Dots: the sign is in doubt.{hatched(whole)}"
