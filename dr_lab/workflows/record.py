"""The verb `record`: logs as MCAP files, whatever they come from."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from dr_lab.recorders.files import write_bytes
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


def record(source: Source, output: str | None, seed: int, run_dir: Path) -> tuple[Path, ...]:
    """Write every log of a source as an MCAP file.

    Args:
        source: where the logs come from.
        output: folder to write to; None means the run folder. Files of the same name are replaced, others stay.
        seed: of everything random in the source.
        run_dir: the run folder.

    Returns:
        The MCAP files, in the source's order.

    Raises:
        DrLabError: the folder cannot be written to.
    """
    folder = run_dir if output is None else Path(output).expanduser()
    written = []
    for log in source.logs(seed):
        path = folder / f"{log.name}.mcap"
        write_mcap(path, log.topics, {}, log.metadata)
        written.append(path)
    for name, content in source.companions(seed).items():
        write_bytes(folder / name, content)
    print(f"{len(written)} logs in {folder}: {', '.join(path.name for path in written)}")
    return tuple(written)
