"""Machines that rest under commands which moved them before: switched off, stopped in an emergency, or stuck."""

import numpy as np
from numpy.typing import NDArray

from dr_lab.channel_names import POSITION, quantity
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.split import until
from dr_lab.trajectory import Array, Log, Note

_BINS = 0.05  # s, stretches that are judged as at rest or moving


def find_resting(log: Log, contract: DataContract) -> list[Note]:
    """A span of at least `contract.resting` s in which every position stays, while all commands go on as strong.

    At rest is what moves by less than `contract.resting_share` of its usual movement in a twentieth of a second.
    Commands go on if each covers, within the span, `contract.resting_drive` of the range and of the scatter that it has
    while the machine moves: friction holds against weak commands, a stop against those in one direction.
    """
    positions = [signal for name, signal in log.outputs.items() if quantity(name) == POSITION]
    if not positions or not log.commands:
        return []
    begin = max(signal.time[0] for signal in (*positions, *log.commands.values()))
    end = min(signal.time[-1] for signal in (*positions, *log.commands.values()))
    edges = np.arange(begin, end, _BINS)
    if len(edges) < 4:
        return []
    rests = np.all([_rests(signal.time, signal.value, edges, contract) for signal in positions], axis=0)
    first, last = _longest(rests)
    begin, end = float(edges[first]), float(edges[last])
    if end - begin < contract.resting or rests.mean() > 1 - contract.resting_share:
        return []
    for signal in log.commands.values():
        inside = (signal.time >= begin) & (signal.time <= end)
        moving = ~rests[np.clip(np.searchsorted(edges, signal.time) - 1, 0, len(rests) - 1)]
        if not _as_strong(signal.value[inside], signal.value[moving & ~inside], contract.resting_drive):
            return []
    message = (
        f"Off: from {begin:.2f} to {end:.2f} s nothing moves, though {', '.join(log.commands)} "
        f"{'go' if len(log.commands) > 1 else 'goes'} on as before. The machine seems switched off or stuck; take the "
        f"parts of the log without it, {until(log.name, begin)}, or leave it out."
    )
    return [Note("fault", "", message)]


def _rests(time: Array, value: Array, edges: Array, contract: DataContract) -> NDArray[np.bool_]:
    """Which stretches a position rests in; one without a sample as long as the samples around it are the same."""
    starts = np.minimum(np.searchsorted(time, edges), len(time) - 1)
    moved = (np.maximum.reduceat(value, starts) - np.minimum.reduceat(value, starts))[:-1]
    silent, across = np.diff(starts) == 0, np.abs(value[starts] - value[np.maximum(starts - 1, 0)])[:-1]
    moved = np.where(silent, across, moved)
    return moved <= contract.resting_share * np.quantile(moved, 0.75)


def _longest(rests: NDArray[np.bool_]) -> tuple[int, int]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], rests, [False]]).astype(int)))
    if not len(edges):
        return 0, 0
    begins, ends = edges[::2], edges[1::2]
    k = int((ends - begins).argmax())
    return int(begins[k]), int(ends[k])


def _as_strong(inside: Array, outside: Array, share: float) -> bool:
    if len(inside) < 4 or len(outside) < 4 or not np.ptp(outside):
        return False
    return bool(np.ptp(inside) >= share * np.ptp(outside) and inside.std() >= share * outside.std())
