"""Which logs are fitted and which are held out; and those that cannot be used."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from glob import escape
from pathlib import Path

from dr_lab.measurements.log_file import kind
from dr_lab.proposal.coverage import reach_of, within
from dr_lab.proposal.propose import Proposal
from dr_lab.proposal.rooms import Rooms
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.trajectory import Array, Log

_FEWEST = 3  # logs of which one may be chosen
_SHOWN = 12  # digits of a time in s


@dataclass(frozen=True)
class Split:
    """How logs are used.

    Attributes:
        files: absolute paths or globs.
        fit: names; None takes all that are not held out.
        held_out: names.
        left_out: why, by the name of a log.
        cut: s from the start of the only log that can be used, from which it is held out; None where whole logs are.
        shortened: what is taken of a log and why no more, by the name that it had.
        covered: whether the held-out logs lie within what the fitted ones cover; None where that is not known.
    """

    files: tuple[str, ...]
    fit: tuple[str, ...] | None
    held_out: tuple[str, ...]
    left_out: Mapping[str, str]
    cut: float | None = None
    shortened: Mapping[str, str] = field(default_factory=dict)
    covered: bool | None = None

    def said(self, logs: int) -> str:
        """How so many logs are used, in a few words."""
        parts = [f"{logs} log{'s' * (logs != 1)}"]
        if self.left_out:
            parts.append(f"{len(self.left_out)} left out")
        if self.cut is None:
            parts.append(f"{len(self.held_out)} held out{self.said_of_reach}")
        else:
            which = "of the other the" if self.left_out else "its"
            parts.append(f"{which} first {self.cut:.{_SHOWN}g} s fitted and the rest held out")
        return ", ".join(parts)

    @property
    def said_of_reach(self) -> str:
        """How the held-out logs lie to the fitted ones, as the end of a sentence; empty where that is not known."""
        if self.covered is None:
            return ""
        return " within what the fitted ones cover" if self.covered else " that reach beyond the fitted ones"


def covering(
    split: Split, logs: Sequence[Log], names: Sequence[str], rooms: Rooms, settings: ProposalSettings
) -> Split:
    """The split whose held-out logs lie within what the fitted ones cover, as far as whole logs allow it.

    What is fitted to small motions is not scored on large ones. Of less than three logs, none can be chosen by that.
    Logs that hold no window are not held out, and those that hold few neither, where others cover as much.

    Args:
        split: every third log or so held out.
        logs: all that are used, read.
        names: of all logs in order, by which the nearest is exchanged for another.
        rooms: how many windows they hold.
        settings: how much farther a held-out log may reach.
    """
    if split.cut is not None:
        return split
    ordered = sorted(logs, key=lambda log: names.index(log.name))
    used = [log.name for log in ordered]
    reach = reach_of(ordered, settings.half_width) if len(logs) >= _FEWEST else None
    held, covered = rooms.held(split.held_out, used, settings.several), None
    if reach is not None:
        options = [
            within(reach, some, settings.reach, rooms.may_replace(some, enough))
            for enough in (settings.several, 1)
            if (some := rooms.held(split.held_out, used, enough))
        ]
        inside = [each for each in options if reach.beyond(each).max() <= settings.reach]
        held, covered = [*inside, *options][0], bool(inside)
    fit = None if split.fit is None else tuple(name for name in used if name not in held)
    return replace(split, fit=fit, held_out=held, covered=covered)


def split_logs(proposal: Proposal, left_out: Mapping[str, str], share: float) -> Split:
    """Hold out every third log or so; of a single log its end.

    Args:
        proposal: names the logs.
        left_out: logs that cannot be used, with the reason.
        share: of the logs, to hold out.
    """
    logs = [name for name in proposal.logs.logs if name not in left_out]
    files = _files([path for name, path in proposal.logs.files.items() if name not in left_out])
    named = tuple(logs) if left_out else None
    if len(logs) == 1:
        cut = _cut(proposal.outputs[0].parts[0].signals[0].time, 1 - share)
        at = f"{cut:.{_SHOWN}g}"
        return Split(files, (f"{logs[0]}[:{at}]",), (f"{logs[0]}[{at}:]",), left_out, cut)
    every = max(round(1 / share), 2)
    held = tuple(logs[every - 1 :: every]) or (logs[-1],)
    fit = tuple(name for name in named if name not in held) if named else None
    return Split(files, fit, held, left_out)


def _cut(time: Array, share: float) -> float:
    """When a share of the times has passed, in s, to three digits of how long that takes."""
    lasts = share * float(time[-1] - time[0])
    places = 2 - math.floor(math.log10(lasts))
    return round(float(time[0]) + lasts, places)


def _files(paths: Sequence[Path]) -> tuple[str, ...]:
    """One glob where the logs are all files of their kind in a folder; else each."""
    whole = [path.absolute() for path in paths]
    folders, suffixes = {path.parent for path in whole}, {path.suffix for path in whole}
    if len(folders) == len(suffixes) == 1 and len(whole) > 1 and kind(whole[0]) != "bag":
        folder, pattern = folders.pop(), f"*{suffixes.pop()}"
        if sorted(folder.glob(pattern)) == sorted(whole):
            return (str(Path(escape(str(folder))) / pattern),)
    return tuple(map(str, whole))
