"""Commands that changed without being logged: what a straight line between their samples misses, as unknowns."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dr_lab.trajectory import Array, Log, Signal


@dataclass(frozen=True)
class Unlogged:
    """What commands may have done between their samples in w windows, as k unknowns each, of standard deviation 1.

    A command that steps from u to u + Δ at an instant that is as likely as any other between two samples differs from
    the line between them by Δ / √12 in the mean over that time, one standard deviation; one that goes smoothly by less.

    Attributes:
        column: column in `ctrl` that each unknown acts on, shape (w, k).
        size: by how much one standard deviation of it changes the control of each step, shape (w, k, s).
    """

    column: NDArray[np.intp]
    size: Array

    def pick(self, rows: NDArray[np.intp]) -> "Unlogged":
        """The unknowns of some windows."""
        return Unlogged(self.column[rows], self.size[rows])

    def until(self, steps: int) -> "Unlogged":
        """The same in the first steps alone."""
        return replace(self, size=self.size[:, :, :steps])

    def added(self, controls: Array, unknown: Array) -> Array:
        """Controls (w, s, nu) changed by unknowns (c, w, k), shape (c, w, s, nu)."""
        every = np.repeat(controls[None], len(unknown), axis=0)
        for column in np.unique(self.column):
            acting = np.where(self.column == column, unknown, 0.0)
            every[..., column] += np.einsum("cwk,wks->cws", acting, self.size)
        return every


def unlogged(
    logs: Sequence[Log], begins: Sequence[Array], columns: Mapping[str, int], edges: Array, most: int
) -> Unlogged | None:
    """The unknowns of windows: of each interval between two samples in a window one; None where all commands are known.

    Args:
        logs: the logs.
        begins: s on each log's clock at which its windows start.
        columns: column of each command.
        edges: of the windows' steps, s after the start, shape (s + 1,).
        most: so many unknowns a window at most, those that change the controls most.
    """
    names = [name for name in columns if any(unknown(log.commands.get(name)) for log in logs)]
    if not names:
        return None
    rows = [
        _in_window(log, names, columns, begin + edges) for log, each in zip(logs, begins, strict=True) for begin in each
    ]
    count = min(most, max(len(column) for column, _ in rows))
    column = np.zeros((len(rows), count), np.intp)
    size = np.zeros((len(rows), count, len(edges) - 1))
    for k, (of_row, sizes) in enumerate(rows):
        chosen = np.sort(np.argsort(-np.abs(sizes).sum(1), kind="stable")[:count])
        column[k, : len(chosen)], size[k, : len(chosen)] = of_row[chosen], sizes[chosen]
    return Unlogged(column, size)


def unknown(signal: Signal | None) -> bool:
    """Whether a command changed without being logged."""
    return signal is not None and signal.between == "unknown"


def _in_window(
    log: Log, names: Sequence[str], columns: Mapping[str, int], edges: Array
) -> tuple[NDArray[np.intp], Array]:
    """Columns (k,) and sizes (k, s) of the intervals that a window's steps touch."""
    column, sizes = [], [np.zeros((0, len(edges) - 1))]
    for name in names:
        signal = log.commands.get(name)
        if signal is not None and unknown(signal):
            first = max(int(np.searchsorted(signal.time, edges[0], side="right")) - 1, 0)
            last = min(int(np.searchsorted(signal.time, edges[-1])), len(signal) - 1)
            time, change = signal.time[first : last + 1], np.abs(np.diff(signal.value[first : last + 1]))
            inside = np.clip(edges, time[:-1, None], time[1:, None])
            sizes.append(change[:, None] / np.sqrt(12.0) * np.diff(inside, axis=1) / np.diff(edges))
            column += [columns[name]] * len(change)
    return np.array(column, np.intp), np.concatenate(sizes)
