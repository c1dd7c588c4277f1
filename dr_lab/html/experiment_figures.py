"""The command that would decide between rivals, as its file holds it."""

from pathlib import Path

import numpy as np
import plotly.graph_objects as go

from dr_lab.html.figure import Plot, chart, line, numbers, series
from dr_lab.reports.gap_entries import ExperimentEntry

_HEIGHT = 260  # px


def experiment_plots(folder: Path, proposal: ExperimentEntry | None) -> list[Plot]:
    """Held commands against time; nothing without a proposal.

    Args:
        folder: that holds the command file.
        proposal: what is proposed.
    """
    if proposal is None or not proposal.command_file or not (folder / proposal.command_file).is_file():
        return []
    with (folder / proposal.command_file).open(encoding="utf-8") as file:
        _, *names = file.readline().strip().split(",")
        time, *commands = np.loadtxt(file, delimiter=",", ndmin=2).T
    figure = chart()
    for index, (name, value) in enumerate(zip(names, commands, strict=True)):
        style = line(series(index + 3), shape="hv")
        figure.add_trace(go.Scatter(x=numbers(time), y=numbers(value), name=name, showlegend=True, **style))
    figure.update_xaxes(title="t [s]")
    figure.update_yaxes(title="command")
    return [Plot(figure, _HEIGHT, f"{proposal.command_file}, to be played on the machine.")]
