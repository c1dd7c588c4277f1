"""A channel: measured and simulated, what is left of it, and whether that is noise."""

from collections.abc import Mapping, Sequence

import numpy as np
import plotly.graph_objects as go
from scipy.stats import norm

from dr_lab.diagnosis.fit.correlation import autocorrelation
from dr_lab.html.command_figures import Stairs, command_plots
from dr_lab.html.figure import INK, NOISE, ROLES, Plot, band, chart, line, numbers
from dr_lab.html.thinning import thinned
from dr_lab.recorders.overlay import AFTER, MEASURED, SIMULATED, Overlay, components
from dr_lab.recorders.signals import held_until, residual
from dr_lab.reports.quantity import number, percent, titled
from dr_lab.trajectory import Array, Signal

_CHANCE = 0.99  # of white noise whose autocorrelation lies within the band
_NOISY = 20.0  # standard deviations of the noise, up to which residuals hide the band
_LAGS = 0.25  # longest lag over the length of what is known
_ANEW = "The simulation begins anew from the measured state{}: there its curves break, and residuals jump."
_HEIGHT, _ROOM = 170, 100  # px of a row, and of legend and title


def channel_plots(overlay: Overlay, points: int) -> list[Plot]:
    """Plots of one log.

    Args:
        overlay: the log.
        points: of a curve, about.
    """
    curves = [_curves(overlay, channel, points) for channel in overlay.measured]
    correlations = [plot for channel in overlay.measured for plot in _correlation(overlay, channel)]
    return [*curves, *correlations, *_commands(overlay, points)]


def _curves(overlay: Overlay, channel: str, points: int) -> Plot:
    """Signal, residuals, and the residual after, whose axis the one before does not stretch."""
    signal, left = overlay.measured[channel], _residuals(overlay, channel)
    rows = [*([left] if left else []), *([{AFTER: left[AFTER]}] if len(left) > 1 else [])]
    titles = [titled(channel, signal.unit) + _fit(signal, left), *(_title(row) for row in rows)]
    figure = chart(len(titles), 1, titles, shared_xaxes=True, vertical_spacing=0.1)
    shown = {MEASURED: signal.value, **{role: overlay.simulated[role][channel] for role in left}}
    for role, value in shown.items():
        _add(figure, *_drawn(overlay, signal.time, value, role), role, overlay.label(role), row=1, points=points)
    for place, each in enumerate(rows, start=2):
        std = overlay.residual_std(channel)
        _add_band(figure, signal, std, place)
        for role, value in each.items():
            _add(figure, *_drawn(overlay, signal.time, value, role), role, "", row=place, points=points)
        _add_edges(figure, signal, std, list(each.values()), place)
    figure.update_yaxes(title=titled("", overlay.residual_unit(channel)).strip())
    figure.update_yaxes(title=titled("", signal.unit).strip(), row=1, col=1)
    figure.update_xaxes(title="t [s]", row=len(titles), col=1)
    return Plot(figure, _ROOM + _HEIGHT * len(titles), _anew(overlay) if left else "")


def _anew(overlay: Overlay) -> str:
    length = overlay.length()
    return _ANEW.format(" at each window's start" if length is None else f" every {number(length, 3)} s")


def _drawn(overlay: Overlay, time: Array, value: Array, role: str) -> tuple[Array, Array]:
    """Times and components of a curve; a simulated one is broken where it begins anew."""
    return (time, components(value)) if role == MEASURED else overlay.broken(time, components(value))


def _residuals(overlay: Overlay, channel: str) -> dict[str, Array]:
    """Measured − simulated by role, shape (n, k)."""
    measured = overlay.measured[channel].value
    roles = [role for role in SIMULATED if channel in overlay.simulated.get(role, {})]
    return {role: components(residual(measured, overlay.simulated[role][channel])) for role in roles}


def _fit(signal: Signal, left: Mapping[str, Array]) -> str:
    """How well the curves that are drawn fit, 1 − ‖y − ŷ‖/‖y − ȳ‖; of orientations, whose residual is a turn, none."""
    told = []
    for value in left.values():
        known = np.isfinite(value).all(axis=1)
        own = components(signal.value)[known]
        spread = float(np.linalg.norm(own - own.mean(axis=0))) if known.any() else 0.0
        if spread > 0 and own.shape == value[known].shape:
            told.append(percent(1.0 - float(np.linalg.norm(value[known])) / spread))
    return f" · fit {' → '.join(told)}" if told else ""


def _title(row: Mapping[str, Array]) -> str:
    return f"residual, measured − simulated{', after alone' if [*row] == [AFTER] else ''}"


def _add(figure: go.Figure, time: Array, value: Array, role: str, label: str, row: int, points: int) -> None:
    """A curve a component; those of one role share a colour and a place in the legend."""
    style = line(ROLES[role], 2.5 if role == MEASURED else 1.3)
    for index, column in enumerate(value.T):
        x, y = thinned(time, column, max(points // value.shape[1], 2))
        named = bool(label) and index == 0
        trace = go.Scatter(x=x, y=numbers(y), name=label, legendgroup=role, showlegend=named, **style)
        figure.add_trace(trace, row=row, col=1)


def _add_band(figure: go.Figure, signal: Signal, std: float | None, row: int) -> None:
    if std is not None and len(signal):
        ends = signal.time[[0, -1]]
        edge = np.full(2, std)
        named = {"name": "noise ±σ", "legendgroup": "noise", "showlegend": row == 2}
        figure.add_trace(band(ends, -edge, edge, NOISE, **named), row=row, col=1)


def _add_edges(figure: go.Figure, signal: Signal, std: float | None, left: Sequence[Array], row: int) -> None:
    """Those of the band, above a curve that hides it because it is little more than noise."""
    largest = max((np.abs(value[np.isfinite(value)]).max(initial=0.0) for value in left), default=0.0)
    if std is None or not len(signal) or largest > _NOISY * std:
        return
    style = {"legendgroup": "noise", "showlegend": False, "hoverinfo": "skip", **line(INK, 1.0, dash="dot")}
    for edge in (-std, std):
        figure.add_trace(go.Scatter(x=signal.time[[0, -1]], y=[edge, edge], **style), row=row, col=1)


def _correlation(overlay: Overlay, channel: str) -> list[Plot]:
    """Autocorrelation of the residuals, beside the band that white noise keeps to."""
    figure, longest, wait = chart(), 0.0, overlay.measured[channel].wait
    for role, value in _residuals(overlay, channel).items():
        known = np.logical_and.reduce(np.isfinite(value), axis=1)
        if known.sum() < 8:
            continue
        rho = np.mean([autocorrelation(column[None], known[None]) for column in value.T], axis=0)
        rho = rho[: max(2, int(_LAGS * known.sum()))]
        lag = np.arange(len(rho)) * wait
        edge, longest = norm.ppf(0.5 + _CHANCE / 2) / np.sqrt(known.sum()), max(longest, float(lag[-1]))
        x, y = thinned(lag, rho, 500)
        figure.add_trace(go.Scatter(x=x, y=numbers(y), name=overlay.label(role), **line(ROLES[role])))
        figure.add_hrect(-edge, edge, fillcolor="var(--noise-soft)", line_width=0, layer="below")
    if not figure.data:
        return []
    figure.add_hline(0.0, line={"color": INK, "width": 1})
    figure.update_xaxes(title="lag [s]", range=[0.0, longest])
    figure.update_yaxes(title="autocorrelation", range=[-1.05, 1.05])
    caption = f"Residual of {channel}. Grey: where {percent(_CHANCE)} of white noise stays."
    return [Plot(figure, 260, caption, half=True)]


def _commands(overlay: Overlay, points: int) -> list[Plot]:
    """Every command as the stairs that the actuator saw."""
    end = overlay.span()[1]
    held = ((name, signal.unit, held_until(signal, end)) for name, signal in overlay.commands.items())
    return command_plots([Stairs(name, unit, *thinned(*curve, points)) for name, unit, curve in held], half=True)
