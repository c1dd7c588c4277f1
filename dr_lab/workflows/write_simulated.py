"""`simulated.mcap`: the scored logs beside what the models make of them, for any MCAP tool."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

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
    predecessor, or begin before time 0, is shifted, and the metadata say by how much.

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
    joints = [name.removesuffix(".position") for name in overlay.measured if name.endswith(".position")]
    if not joints:
        return []
    time = overlay.measured[f"{joints[0]}.position"].time
    real = np.stack([_at(overlay.measured[f"{j}.position"], time) for j in joints], axis=1)
    simulated = {role: _columns(overlay, role, joints, time) for role in overlay.simulated}
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


def _columns(overlay: Overlay, role: str, joints: Sequence[str], time: Array) -> Array:
    signals = [overlay.measured[f"{j}.position"] for j in joints]
    values = [overlay.simulated[role][f"{j}.position"] for j in joints]
    return np.stack([np.interp(time, s.time, v) for s, v in zip(signals, values, strict=True)], axis=1)


def _at(signal: Signal, time: Array) -> Array:
    return np.interp(time, signal.time, signal.value)
