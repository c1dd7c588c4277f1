"""Which logs are fitted and which are held out; and those that cannot be used."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from dr_lab.measurements.log_file import kind
from dr_lab.proposal.propose import Proposal


@dataclass(frozen=True)
class Split:
    """How logs are used.

    Attributes:
        files: absolute paths or globs.
        fit: names; None takes all that are not held out.
        held_out: names.
        left_out: why, by the name of a log.
    """

    files: tuple[str, ...]
    fit: tuple[str, ...] | None
    held_out: tuple[str, ...]
    left_out: Mapping[str, str]


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
        time = proposal.outputs[0].parts[0].signals[0].time
        cut = f"{time[0] + (1 - share) * (time[-1] - time[0]):.3g}"
        return Split(files, (f"{logs[0]}[:{cut}]",), (f"{logs[0]}[{cut}:]",), left_out)
    every = max(round(1 / share), 2)
    held = tuple(logs[every - 1 :: every]) or (logs[-1],)
    fit = tuple(name for name in named if name not in held) if named else None
    return Split(files, fit, held, left_out)


def _files(paths: Sequence[Path]) -> tuple[str, ...]:
    """One glob where the logs are all files of their kind in a folder; else each."""
    whole = [path.absolute() for path in paths]
    folders, suffixes = {path.parent for path in whole}, {path.suffix for path in whole}
    if len(folders) == len(suffixes) == 1 and len(whole) > 1 and kind(whole[0]) != "bag":
        glob = folders.pop() / f"*{suffixes.pop()}"
        if sorted(glob.parent.glob(glob.name)) == sorted(whole):
            return (str(glob),)
    return tuple(map(str, whole))
