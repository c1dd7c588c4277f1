"""Views of a log against time: channels, their residuals, and the commands."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun.blueprint as rrb

from dr_lab.recorders.branch import entity_path
from dr_lab.recorders.free_corner import free_corner
from dr_lab.recorders.numbered_axis import numbered_axis
from dr_lab.recorders.overlay import AFTER, SIMULATED, Overlay
from dr_lab.recorders.signals import residual
from dr_lab.reports.quantity import number, titled
from dr_lab.trajectory import Array

# Rows of plots that can be read on one sheet, beside that of the commands.
_ROWS = 3
_LINKED = rrb.TimeAxis(link="LinkToGlobal")


@dataclass(frozen=True)
class _Plot:
    """A plot against time.

    Attributes:
        parts: the entity that it shows.
        title: quantity and unit.
        curves: times and values of what is drawn.
        entities: below that entity, that are drawn.
        legend: whether it says which colour is what.
    """

    parts: Sequence[str]
    title: str
    curves: Sequence[tuple[Array, Array]]
    entities: Sequence[str] = ("**",)
    legend: bool = False

    def view(self, rows: int) -> rrb.TimeSeriesView:
        """The view, one of so many below one another."""
        return rrb.TimeSeriesView(
            origin=entity_path(*self.parts),
            contents=[f"$origin/{entity}" for entity in self.entities],
            name=self.title,
            axis_x=_LINKED,
            axis_y=numbered_axis((value for _, value in self.curves), rows),
            plot_legend=rrb.PlotLegend(free_corner(self.curves), visible=self.legend),
        )


def signals_page(overlay: Overlay) -> rrb.Container:
    """A row a channel, a few a sheet, each above the commands."""
    channels = list(overlay.measured)
    groups = [channels[start : start + _ROWS] for start in range(0, len(channels), _ROWS)]
    sheets = [rrb.Vertical(*_sheet(overlay, group), name=" · ".join(group)) for group in groups]
    return sheets[0] if len(sheets) == 1 else rrb.Tabs(*sheets)


def channel_views(overlay: Overlay, channels: Sequence[str]) -> list[rrb.TimeSeriesView]:
    """Signal and residual of each channel, all below one another; the first says which colour is what."""
    plots = [
        each for channel in channels for each in (_signal(overlay, channel, channels), *_residual(overlay, channel))
    ]
    return [plot.view(len(plots)) for plot in plots]


def _sheet(overlay: Overlay, channels: Sequence[str]) -> list[rrb.Container]:
    """A row a channel: signal, residual, and the residual after, whose axis the one before does not stretch."""
    plots = [
        [_signal(overlay, channel, channels), *_residual(overlay, channel), *_after_alone(overlay, channel)]
        for channel in channels
    ]
    plots += [[_commands(overlay)]] if overlay.commands else []
    return [rrb.Horizontal(*(plot.view(len(plots)) for plot in row)) for row in plots]


def _signal(overlay: Overlay, channel: str, channels: Sequence[str]) -> _Plot:
    signal = overlay.measured[channel]
    simulated = [values[channel] for values in overlay.simulated.values() if channel in values]
    curves = [(signal.time, value) for value in (signal.value, *simulated)]
    title = titled(channel, signal.unit)
    return _Plot([overlay.log, "signal", channel], title, curves, legend=channel == channels[0])


def _residual(overlay: Overlay, channel: str) -> list[_Plot]:
    curves = [_left(overlay, channel, role) for role in SIMULATED if channel in overlay.simulated.get(role, {})]
    if not curves:
        return []
    anew = f", anew every {number(length, 3)} s" if (length := overlay.length()) else ""
    title = titled(f"{channel}, measured − simulated", overlay.residual_unit(channel)) + anew
    return [_Plot([overlay.log, "residual", channel], title, curves)]


def _after_alone(overlay: Overlay, channel: str) -> list[_Plot]:
    missing = any(channel not in overlay.simulated.get(role, {}) for role in SIMULATED)
    if missing or not len(overlay.measured[channel].time):
        return []
    std, (time, value) = overlay.residual_std(channel), _left(overlay, channel, AFTER)
    title = titled("after alone", overlay.residual_unit(channel))
    title += "" if std is None else f", grey: noise ±{number(std, 3)}"
    curves = [(time, value), *([] if std is None else [(time[[0, -1]], np.array([-std, std]))])]
    return [_Plot([overlay.log, "residual", channel], title, curves, ["sim_after", "noise"])]


def _commands(overlay: Overlay) -> _Plot:
    curves = [(signal.time, signal.value) for signal in overlay.commands.values()]
    units = ", ".join(dict.fromkeys(signal.unit for signal in overlay.commands.values()))
    title = titled("commands", units)
    return _Plot([overlay.log, "command"], title, curves, legend=True)


def _left(overlay: Overlay, channel: str, role: str) -> tuple[Array, Array]:
    """Times and measured − simulated."""
    measured = overlay.measured[channel]
    return measured.time, residual(measured.value, overlay.simulated[role][channel])
