"""The verb `record`: logs as MCAP files, whatever they come from."""

from pathlib import Path

from dr_lab.bounds import Natural
from dr_lab.sources.source import Source, write_logs


def record(source: Source, output: str | None, seed: Natural, run_dir: Path) -> tuple[Path, ...]:
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
    written = write_logs(source, seed, folder)
    print(f"{len(written)} logs in {folder}: {', '.join(path.name for path in written)}")
    return written
