"""Plots in the page's own colours, which the reader's theme decides."""

import html
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray
from plotly.subplots import make_subplots

from dr_lab.html.thinning import Numbers
from dr_lab.trajectory import Array

# Names of the style sheet's colours, which the page puts in their place.
INK, MUTED, GRID = "var(--ink)", "var(--muted)", "var(--grid)"
MEASURED, BEFORE, AFTER, NOISE = "var(--measured)", "var(--before)", "var(--after)", "var(--noise)"
ROLES = {"measured": MEASURED, "before": BEFORE, "after": AFTER}
SERIES = 7  # colours of groups that the style sheet has
_FEW_TICKS = 10
_MARKUP = ("hovertemplate", "bdata")  # what is no text of a user
ROW = 26  # px of a labelled row
_TOP, _BOTTOM = 48, 56  # px beside the axes, for legend and title
_NAME = 40  # letters of a title

_AXIS = {
    "color": MUTED,
    "gridcolor": GRID,
    "zerolinecolor": GRID,
    "linecolor": GRID,
    "automargin": True,
    "exponentformat": "power",
    "hoverformat": ".4g",
    "ticks": "outside",
    "tickcolor": GRID,
    "title": {"standoff": 8},
}
_TEMPLATE = go.layout.Template(
    layout={
        "font": {"family": "system-ui, sans-serif", "size": 13, "color": INK},
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "margin": {"l": 16, "r": 16, "t": _TOP, "b": _BOTTOM},
        "legend": {"orientation": "h", "x": 0, "y": 1, "yanchor": "top", "yref": "container"},
        "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": MUTED, "activecolor": INK},
        "hoverlabel": {"namelength": -1},
        "xaxis": _AXIS,
        "yaxis": _AXIS,
    }
)


@dataclass(frozen=True)
class Plot:
    """A figure on the page.

    Attributes:
        figure: what is drawn.
        height: px.
        caption: a sentence below it.
        half: whether two stand side by side where there is room.
    """

    figure: go.Figure
    height: int
    caption: str = ""
    half: bool = False

    def json(self) -> str:
        """Traces and layout, safe within HTML: texts are escaped for Plotly, which knows markup, and for the page."""
        return json.dumps(
            _escaped(json.loads(str(self.figure.to_json()))), ensure_ascii=False, separators=(",", ":")
        ).replace("<", r"\u003c")


def chart(rows: int = 1, columns: int = 1, titles: Sequence[str] = (), **grid: Any) -> go.Figure:  # noqa: ANN401
    """An empty figure of one or more pairs of axes; `grid` as Plotly's `make_subplots` takes it."""
    figure = make_subplots(rows=rows, cols=columns, subplot_titles=[*titles] or None, **grid)
    figure.update_layout(template=_TEMPLATE)
    figure.update_annotations(font={"size": 13, "color": MUTED})
    return figure


def whole_ticks(last: float) -> dict[str, Any]:
    """Of an axis that counts to so few that ticks would stand between whole numbers."""
    return {"dtick": 1} if last <= _FEW_TICKS else {}


def headed(figure: go.Figure, name: str, more: str) -> go.Figure:
    """The same figure with a title: a name, cut off where it is too long for half the page, and more of it."""
    short = name if len(name) <= _NAME else f"{name[: _NAME - 1]}…"
    place = {"x": 0.0, "xref": "container", "y": 1.0, "yref": "container", "yanchor": "top", "pad": {"t": 4, "l": 16}}
    return figure.update_layout(title={"text": f"{short} · {more}", "font": {"size": 14}, **place})


def rows_height(count: int) -> int:
    """Height in px of a figure with so many labelled rows."""
    return _TOP + _BOTTOM + ROW * (count + 1)


def series(index: int) -> str:
    """Colour of a group, in turn."""
    return f"var(--series-{index % SERIES})"


def soft(colour: str) -> str:
    """The same colour, to be seen through."""
    return colour.replace(")", "-soft)")


def numbers(value: Numbers) -> NDArray[np.float32]:
    """Values to seven digits, which take half the room."""
    return np.asarray(value, dtype=np.float32)


def line(colour: str, width: float = 1.5, **more: Any) -> dict[str, Any]:  # noqa: ANN401
    """Style of a line."""
    return {"mode": "lines", "line": {"color": colour, "width": width, **more}}


def band(x: Numbers, low: Array, high: Array, colour: str, **more: Any) -> go.Scatter:  # noqa: ANN401
    """What lies between two lines, where both are known."""
    known = np.isfinite(low) & np.isfinite(high)
    around = np.concatenate([x[known], x[known][::-1]]), np.concatenate([high[known], low[known][::-1]])
    style = {"mode": "lines", "line": {"width": 0}, "fill": "toself", "fillcolor": soft(colour)}
    return go.Scatter(x=around[0], y=numbers(around[1]), hoverinfo="skip", **style, **more)


def _escaped(value: object, key: str = "") -> object:
    """Texts in which Plotly finds no markup of its own but ends of lines."""
    if isinstance(value, Mapping):
        return {name: _escaped(item, str(name)) for name, item in value.items()}
    if isinstance(value, list):
        return [_escaped(item, key) for item in value]
    if not isinstance(value, str) or key in _MARKUP:
        return value
    return html.escape(value, quote=False).replace("\n", "<br>")
