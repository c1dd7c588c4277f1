"""Where a joint comes to rest while its command holds: at the command, if that is a position."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.survey import Series
from dr_lab.trajectory import Array, Signal

_HELD = 1e-6  # share of a command's range that rounding makes
_FEWEST = 2  # rests: the line through them must go by a known unit, and through zero
_ENDING = 0.3  # share of a hold, its last, in which a joint that settles moves no more
_LEAST = 4  # samples of that


@dataclass(frozen=True)
class Settled:
    """Rests of a joint: position = ratio · command + offset, in raw numbers.

    Attributes:
        ratio: numbers of the position per number of the command.
        offset: number of the position at the command 0.
        span: range of the positions at rest.
    """

    ratio: float
    offset: float
    span: float

    def passes_for(self, ratio: float, settings: ProposalSettings) -> bool:
        """Whether the joint comes to rest at its command, if one number of that is so many of the position."""
        off = abs(math.log(abs(self.ratio) / ratio)) if ratio > 0 else math.inf
        return off < math.log(settings.near_unit) and abs(self.offset) < settings.rests_off * self.span


Rests = Mapping[tuple[int, int], Settled]  # by places of a position and of a command


def all_rests(positions: Sequence[Series], commands: Sequence[Series], settings: ProposalSettings) -> Rests:
    """What `settled` says of every position with every command, where it says something."""
    every = {
        (i, k): settled(place, asked, settings)
        for i, place in enumerate(positions)
        for k, asked in enumerate(commands)
        if place is not asked
    }
    return {pair: found for pair, found in every.items() if found is not None}


def unit_by_rests(
    position: Series, commands: Sequence[Series], known: Mapping[str, float], settings: ProposalSettings
) -> str:
    """Unit of a position that comes to rest at a command whose name says its unit; empty where none does.

    Args:
        position: whose name says no unit.
        commands: what may be asked of it.
        known: sizes of the units that it may have.
        settings: what counts as rest.
    """
    for asked in commands:
        rest = settled(position, asked, settings) if asked.words.unit in known else None
        for unit, size in known.items():
            if rest is not None and rest.passes_for(known[asked.words.unit] / size, settings):
                return unit
    return ""


def settled(position: Series, command: Series, settings: ProposalSettings) -> Settled | None:
    """How a joint's rests follow from its command; None where it does not rest, or not by the command.

    Args:
        position: of the joint.
        command: what may be asked of it.
        settings: how long a command holds, what counts as rest, and how well a line must meet the rests.
    """
    most = max(float(np.ptp(signal.value)) for signal in position.signals)
    rests = [
        rest
        for place, asked in zip(position.signals, command.signals, strict=True)
        for rest in _rests(place, asked, settings.rests_moved * most, settings.rests_after)
    ]
    at, goal = np.array(rests).reshape(-1, 2).T
    if len(at) < _FEWEST or np.ptp(goal) == 0 or np.ptp(at) < settings.explained * most:
        return None
    ratio, offset = np.polyfit(goal, at, 1)
    left = float(np.sqrt(((at - ratio * goal - offset) ** 2).mean()))
    span = float(np.ptp(at))
    return Settled(float(ratio), float(offset), span) if ratio and left < settings.rests_off * span else None


def _rests(place: Signal, asked: Signal, still: float, after: float) -> list[tuple[float, float]]:
    """Positions at the ends of long holds, with the commands that held."""
    jumps = np.abs(np.diff(asked.value)) > _HELD * float(np.ptp(asked.value))
    starts = np.concatenate([[0], np.flatnonzero(jumps) + 1])
    ends = np.append(asked.time[starts[1:]], asked.time[-1])
    found = []
    for first, start, end in zip(starts, asked.time[starts], ends, strict=True):
        late = max(start + after, end - _ENDING * (end - start))
        ending: Array = place.value[(place.time > late) & (place.time <= end)]
        if len(ending) >= _LEAST and float(np.ptp(ending)) <= still:
            found.append((float(ending.mean()), float(asked.value[first])))
    return found
