"""Commands against time, as the stairs that actuators see."""

from collections.abc import Sequence
from dataclasses import dataclass

import plotly.graph_objects as go

from dr_lab.html.figure import SERIES, Plot, chart, line, numbers, series
from dr_lab.html.thinning import Numbers
from dr_lab.reports.quantity import titled
from dr_lab.trajectory import Array

_HEIGHT = 260  # px
_FIRST = 3  # colour of the first, which no role has


@dataclass(frozen=True)
class Stairs:
    """A command.

    Attributes:
        name: of the actuator.
        unit: of its values; empty where it is not known.
        time: s, shape (n,).
        value: held until the next, shape (n,).
    """

    name: str
    unit: str
    time: Numbers
    value: Array


def command_plots(commands: Sequence[Stairs], caption: str = "", *, half: bool = False) -> list[Plot]:
    """As many commands a plot as there are colours, by unit.

    Args:
        commands: what is drawn.
        caption: a sentence below each plot.
        half: whether two plots stand side by side, as they also do where there are several.
    """
    units = {unit: [each for each in commands if each.unit == unit] for unit in dict.fromkeys(c.unit for c in commands)}
    groups = [alike[start : start + SERIES] for alike in units.values() for start in range(0, len(alike), SERIES)]
    return [Plot(_figure(group), _HEIGHT, caption, half=half or len(groups) > 1) for group in groups]


def _figure(commands: Sequence[Stairs]) -> go.Figure:
    figure = chart()
    for index, each in enumerate(commands):
        style = line(series(index + _FIRST), shape="hv")
        figure.add_trace(go.Scatter(x=each.time, y=numbers(each.value), name=each.name, showlegend=True, **style))
    figure.update_xaxes(title="t [s]")
    return figure.update_yaxes(title=titled("command", commands[0].unit))
