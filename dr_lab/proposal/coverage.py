"""Held-out logs that lie within what the fitted ones cover: where the joints are, and how fast they move."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.channel_names import POSITION, quantity
from dr_lab.trajectory import Array, Log, Signal


@dataclass(frozen=True)
class Reach:
    """How far each log goes, in each direction of each measure, as a share of what all logs span together.

    Attributes:
        names: of the logs.
        far: shape (logs, 3 joints): largest and smallest position, and largest speed.
    """

    names: tuple[str, ...]
    far: Array

    def beyond(self, held: Sequence[str]) -> Array:
        """By which share of the whole each held-out log reaches farther than all others, shape (held,)."""
        out = np.isin(self.names, held)
        most = self.far[~out].max(0)
        return np.array([np.maximum(self.far[self.names.index(name)] - most, 0.0).max(initial=0.0) for name in held])


def reach_of(logs: Sequence[Log], window: float) -> Reach | None:
    """How far the measured joints go in each log; None where no joint is measured.

    Args:
        logs: at least one.
        window: s, over which speeds are means, so that they are not the noise's.
    """
    channels = [name for name in logs[0].outputs if quantity(name)]
    if not channels:
        return None
    columns = []
    for name in channels:
        signals = [log.outputs[name] for log in logs]
        if quantity(name) == POSITION:
            high, low = (np.array([end(signal.value) for signal in signals]) for end in (np.max, np.min))
            whole = high.max() - low.min()
            columns += [_share(high, whole), _share(-low, whole)]
        speed = np.array([_speed(signal, window, of_position=quantity(name) == POSITION) for signal in signals])
        columns.append(_share(speed, float(speed.max())))
    return Reach(tuple(log.name for log in logs), np.stack(columns, axis=1))


def within(reach: Reach, held: Sequence[str], most: float, allowed: Collection[str] | None = None) -> tuple[str, ...]:
    """The held-out logs, where one that reaches beyond the others is exchanged for the nearest that does not.

    Args:
        reach: of all logs, in their order.
        held: names of those that are held out at first.
        most: share of the whole by which a held-out log may reach beyond the fitted ones.
        allowed: names of those that may be held out; None allows all.
    """
    held = tuple(held)
    for _ in held:
        beyond = reach.beyond(held)
        if beyond.max() <= most:
            break
        farthest = int(np.argmax(beyond))
        exchanged = _exchanged(reach, held, farthest, most, reach.names if allowed is None else allowed)
        if reach.beyond(exchanged).max() >= beyond.max():
            break
        held = exchanged
    return tuple(name for name in reach.names if name in held)


def _exchanged(
    reach: Reach, held: tuple[str, ...], place: int, most: float, allowed: Collection[str]
) -> tuple[str, ...]:
    """The nearest log in order that may be held out in place of another; the one that reaches least where none may."""
    here = reach.names.index(held[place])
    fitted = [k for k, name in enumerate(reach.names) if name not in held and name in allowed]
    options = [
        (*held[:place], reach.names[k], *held[place + 1 :]) for k in sorted(fitted, key=lambda k: (abs(k - here), k))
    ]
    good = (option for option in options if reach.beyond(option).max() <= most)
    return next(good, min((*options, held), key=lambda option: float(reach.beyond(option).max())))


def _share(values: Array, whole: float) -> Array:
    return values / whole if whole > 0 else 0.0 * values


def _speed(signal: Signal, window: float, *, of_position: bool) -> float:
    """Largest speed, of a position as mean over a window."""
    if not of_position:
        return float(np.abs(signal.value).max())
    later = signal.time[signal.time + window <= signal.time[-1]]
    moved = np.interp(later + window, signal.time, signal.value) - np.interp(later, signal.time, signal.value)
    return float(np.abs(moved).max(initial=0.0)) / window
