"""`simulated.mcap`: the scored logs beside what the models make of them, for any MCAP tool."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from dr_lab.channel_names import POSITION, joint_of, quantity
from dr_lab.recorders.mcap import FloatArrays, JointStates, write_mcap
from dr_lab.recorders.overlay import AFTER, BEFORE, Overlay
from dr_lab.trajectory import Array, Signal

_PAUSE = 1.0  # s between two logs whose clocks overlap


def write_simulated(
    path: Path, overlays: Sequence[Overlay], attachments: Mapping[str, bytes], metadata: Mapping[str, str]
) -> None:
    """Write measured, simulated and residual joint states and the commands.

    Topics: ``/real/joint_states``, ``/sim/joint_states`` (after), ``/sim_before/joint_states``,
    ``/residual/joint_states`` (measured − after), ``/command``. Logs follow one another; one that would overlap its
    predecessor, or begin before time 0, is shifted, and the metadata say by how much. Joints that were sampled at other
    times than the first are interpolated to its times; a message for which one of them pauses is left out.

    Args:
        path: the file.
        overlays: what was measured and simulated, log by log.
        attachments: files to embed, e.g. ``model.xml``.
        metadata: what describes the run.
    """
    free, parts, shifts = 0.0, [], {}
    for overlay in overlays:
        ends = [*overlay.span(), *(time for command in overlay.commands.values() for time in command.time[[0, -1]])]
        shift = max(0.0, free - min(ends))
        free = max(ends) + shift + _PAUSE
        shifts[f"{overlay.log}.shift"] = f"{shift:.9f} s"
        parts.append((overlay, shift))
    topics = [topic for overlay, shift in parts for topic in _topics(overlay, shift)]
    write_mcap(path, topics, attachments, {**metadata, **shifts})


def _topics(overlay: Overlay, shift: float) -> list[JointStates | FloatArrays]:
    joints = [joint_of(name) for name in overlay.measured if quantity(name) == POSITION]
    if not joints:
        return []
    channels = [f"{joint}.{POSITION}" for joint in joints]
    time = overlay.measured[channels[0]].time
    real = _columns(overlay, {c: overlay.measured[c].value for c in channels}, channels, time)
    simulated = {role: _columns(overlay, values, channels, time) for role, values in overlay.simulated.items()}
    best = simulated.get(AFTER, simulated.get(BEFORE))
    named = {"/real": real, "/sim": best, "/sim_before": simulated.get(BEFORE) if AFTER in simulated else None}
    named["/residual"] = None if best is None else real - best
    topics: list[JointStates | FloatArrays] = []
    for prefix, position in named.items():
        if position is not None:
            kept = np.isfinite(position).all(1)
            stamp = time[kept] + shift
            topics.append(JointStates(f"{prefix}/joint_states", tuple(joints), stamp, stamp, position[kept]))
    for name, command in overlay.commands.items():
        topic = "/command" if len(overlay.commands) == 1 else f"/command/{name}"
        topics.append(FloatArrays(topic, (name,), command.time + shift, command.value[:, None]))
    return topics


def _columns(overlay: Overlay, values: Mapping[str, Array], channels: Sequence[str], time: Array) -> Array:
    columns = (_at(overlay.measured[c], values[c], time, overlay.gaps.get(c, np.inf)) for c in channels)
    return np.stack([*columns], axis=1)


def _at(signal: Signal, value: Array, time: Array, gap: float) -> Array:
    """Values at a signal's samples, interpolated to other times; NaN in its gaps and beyond its ends."""
    after = np.clip(np.searchsorted(signal.time, time), 0, len(signal) - 1)
    before = np.maximum(after - 1, 0)
    inside = (time >= signal.time[before]) & (time <= signal.time[after])
    close = (signal.time[after] - signal.time[before] <= gap) | (time == signal.time[after])
    return np.where(inside & close, np.interp(time, signal.time, value), np.nan)
