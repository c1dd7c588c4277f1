"""Frozen sensors, copies and machines at rest under commands, looked for when all logs of a machine are read."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from dr_lab.errors import DataError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.faults.copies import Copy, find_copies
from dr_lab.measurements.faults.frozen import find_frozen, without
from dr_lab.measurements.faults.resting import find_resting
from dr_lab.trajectory import Log, Note


def mark_faults(
    fit: Sequence[Log], held_out: Sequence[Log], contract: DataContract, wraps: Mapping[str, float]
) -> tuple[tuple[Log, ...], tuple[Log, ...]]:
    """The logs with a note of kind ``fault`` on each fault, frozen samples left out as a gap.

    Args:
        fit: logs to fit on.
        held_out: logs that score.
        contract: thresholds.
        wraps: by how much outputs jump in their files, by name.

    Raises:
        DataError: a held-out log holds data of a fitted one.
    """
    logs = (*fit, *held_out)
    notes: list[list[Note]] = [[] for _ in logs]
    for copy in find_copies(logs, contract, wraps):
        if (copy.first < len(fit)) != (copy.second < len(fit)):
            raise DataError(_refusal(logs, copy))
        notes[copy.second].append(_copied(logs, copy))
    marked = tuple(_marked(log, found, contract) for log, found in zip(logs, notes, strict=True))
    return marked[: len(fit)], marked[len(fit) :]


def _marked(log: Log, notes: Sequence[Note], contract: DataContract) -> Log:
    """The log with its notes and those given first, and without frozen samples."""
    outputs, frozen = dict(log.outputs), []
    for name, signal in log.outputs.items():
        spans = find_frozen(signal, contract)
        frozen += [span.note(name) for span in spans]
        outputs[name] = without(signal, spans, contract)
    # Where a sensor froze, its silence says nothing of the machine.
    rest = () if frozen else find_resting(log, contract)
    return replace(log, outputs=outputs, notes=(*notes, *frozen, *rest, *log.notes))


def _copied(logs: Sequence[Log], copy: Copy) -> Note:
    other = logs[copy.first].name
    message = (
        f"Copied: from {copy.begin:.2f} to {copy.end:.2f} s the {copy.samples} samples of {copy.signal} are those of "
        f"log {other} from {copy.begin - copy.later:.2f} s on, bit by bit; they count twice. Leave one of the two out."
    )
    return Note("fault", copy.signal, message, copy.samples)


def _refusal(logs: Sequence[Log], copy: Copy) -> str:
    one, other = logs[copy.first].name, logs[copy.second].name
    return (
        f"Logs {one!r} and {other!r} hold the same data: {copy.samples} samples of {copy.signal} in a row are equal, "
        f"{copy.begin:.2f} to {copy.end:.2f} s of {other!r}, but one is fitted and the other held out. A held-out log "
        "is never fitted; leave one of them out of measurements.fit and measurements.held_out."
    )
