"""The contract of a source: where logs come from that `record` writes."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from dr_lab.files import write_bytes
from dr_lab.recorders.mcap import FloatArrays, JointStates, write_mcap


@dataclass(frozen=True)
class NamedLog:
    """One log ready to be written.

    Attributes:
        name: the file's stem.
        topics: what it holds.
        metadata: key–value pairs of the file's record ``"dr_lab"``.
    """

    name: str
    topics: tuple[JointStates | FloatArrays, ...]
    metadata: Mapping[str, str] = field(default_factory=dict)


class Source(Protocol):
    """Where logs come from."""

    def logs(self, seed: int) -> Iterator[NamedLog]:
        """The logs, one after the other; the same seed gives the same logs."""
        ...

    def companions(self, seed: int) -> Mapping[str, bytes]:
        """Files to put beside the logs, by name."""
        ...


def write_logs(source: Source, seed: int, folder: Path) -> tuple[Path, ...]:
    """Write every log of a source as an MCAP file, and what belongs beside them.

    Args:
        source: where the logs come from.
        seed: of everything random in the source.
        folder: where to; files of the same name are replaced, others stay.

    Returns:
        The MCAP files, in the source's order.

    Raises:
        DrLabError: the folder cannot be written to.
    """
    written = []
    for log in source.logs(seed):
        path = folder / f"{log.name}.mcap"
        write_mcap(path, log.topics, {}, log.metadata)
        written.append(path)
    for name, content in source.companions(seed).items():
        write_bytes(folder / name, content)
    return tuple(written)
