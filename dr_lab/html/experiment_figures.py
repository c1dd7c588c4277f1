"""The command that would decide between rivals, as its file holds it."""

from pathlib import Path

import numpy as np

from dr_lab.html.command_figures import Stairs, command_plots
from dr_lab.html.figure import Plot
from dr_lab.reports.gap_entries import ExperimentEntry


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
    stairs = [
        Stairs(name, proposal.units.get(name, ""), time, value) for name, value in zip(names, commands, strict=True)
    ]
    return command_plots(stairs, f"{proposal.command_file}, to be played on the machine.")
