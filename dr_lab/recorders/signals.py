"""Channels against time: measured and simulated, their residuals, and the commands."""

import numpy as np
import rerun as rr
from scipy.spatial.transform import Rotation

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import MEASURED, SIMULATED, Overlay, is_orientation
from dr_lab.reports.quantity import titled
from dr_lab.trajectory import Array, Signal

_COMPONENTS = {1: ("",), 3: (" x", " y", " z"), 4: (" w", " x", " y", " z")}


def log_signals(root: Branch, overlay: Overlay, look: Look) -> None:
    """Log every channel below ``<root>/signal/<channel>/{measured,sim_before,sim_after}``."""
    for channel, signal in overlay.measured.items():
        curves = {role: values[channel] for role, values in overlay.simulated.items() if channel in values}
        for role, value in {MEASURED: signal.value, **curves}.items():
            place = root / "signal" / channel / _entity(role)
            place.static(_style(role, overlay.label(role), value, look))
            _send(place, *((signal.time, value) if role == MEASURED else overlay.broken(signal.time, value)))


def log_residuals(root: Branch, overlay: Overlay, look: Look) -> None:
    """Log measured − simulated below ``<root>/residual/<channel>/{sim_before,sim_after}``, and the noise as ±σ."""
    for channel, signal in overlay.measured.items():
        for role in SIMULATED:
            if channel in overlay.simulated.get(role, {}):
                value = residual(signal.value, overlay.simulated[role][channel])
                place = root / "residual" / channel / _entity(role)
                place.static(_style(role, overlay.label(role), value, look))
                _send(place, *overlay.broken(signal.time, value))
        std = overlay.residual_std(channel)
        if std is not None and len(signal):
            _log_band(root / "residual" / channel / "noise", signal.time, std, overlay.residual_unit(channel), look)


def log_commands(root: Branch, overlay: Overlay, look: Look) -> None:
    """Log every command below ``<root>/command/<actuator>`` as the stairs that the actuator saw."""
    end = overlay.span()[1]
    for index, (actuator, signal) in enumerate(overlay.commands.items()):
        place = root / "command" / actuator
        style = rr.SeriesLines(
            colors=[look.command(index)],
            names=[titled(actuator, signal.unit)],
            widths=[look.line_width],
            interpolation_mode="StepAfter",
        )
        place.static(style)
        _send(place, *held_until(signal, end))


def residual(measured: Array, simulated: Array) -> Array:
    """Measured − simulated, shape (n,) or (n, k); for orientations wxyz, (n, 4), the turn between them.

    The turn is the rotation vector from the simulated to the measured orientation in rad, world frame, shape (n, 3).
    Rows whose simulated value is NaN stay NaN.
    """
    if not is_orientation(measured):
        return measured - simulated
    turn = np.full((len(measured), 3), np.nan)
    known = np.isfinite(simulated).all(axis=1)
    if known.any():
        target = Rotation.from_quat(measured[known], scalar_first=True)
        turn[known] = (target * Rotation.from_quat(simulated[known], scalar_first=True).inv()).as_rotvec()
    return turn


def _entity(role: str) -> str:
    """Entity of a role; Rerun draws in the order of names, so the measured curve comes below the simulated."""
    return role if role == MEASURED else f"sim_{role}"


def _style(role: str, label: str, value: Array, look: Look) -> rr.SeriesLines:
    columns = 1 if value.ndim == 1 else value.shape[1]
    suffixes = _COMPONENTS.get(columns, tuple(f" {index}" for index in range(columns)))
    return rr.SeriesLines(
        colors=[look.colour(role)] * columns,
        names=[label + suffix for suffix in suffixes],
        widths=[look.measured_width if role == MEASURED else look.line_width] * columns,
    )


def _log_band(place: Branch, time: Array, std: float, unit: str, look: Look) -> None:
    style = rr.Measurements.from_fields(colors=[look.colour("noise")], names=["noise ±σ"], units=[unit])
    place.static(style)
    band = rr.Measurements.columns(values=np.zeros(2), variances=np.full(2, std**2))
    place.over_time(time[[0, -1]], band)


def _send(place: Branch, time: Array, value: Array) -> None:
    if len(time):
        columns = rr.Scalars.columns(scalars=value)
        place.over_time(time, columns)


def held_until(signal: Signal, end: float) -> tuple[Array, Array]:
    """The command with its last value repeated at `end`, if that is later."""
    if not len(signal) or end <= signal.time[-1]:
        return signal.time, signal.value
    return np.append(signal.time, end), np.concatenate([signal.value, signal.value[-1:]])
