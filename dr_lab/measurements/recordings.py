"""Where each log's samples lie: a file, or those rows of a table that share a value."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from dr_lab.errors import ConfigError
from dr_lab.measurements.log_file import TABLES, kind
from dr_lab.measurements.table import grouped
from dr_lab.measurements.table_file import Rows


@dataclass(frozen=True)
class Recording:
    """The place of one log.

    Attributes:
        path: file, or folder of a bag.
        rows: the rows of its table that count; None takes the whole file.
    """

    path: Path
    rows: Rows | None = None


def recordings(files: Mapping[str, Path], group: str | None) -> dict[str, Recording]:
    """All logs of some files by name.

    Args:
        files: by stem, which names the log.
        group: column of tables that hold several logs each; every value of it is a log, called ``stem/value``. None:
            one log a file.

    Raises:
        ConfigError: a file is no table and has no columns.
        DataError: a table is empty or cannot be read.
        UnknownNameError: a table has no such column.
    """
    if group is None:
        return {stem: Recording(path) for stem, path in files.items()}
    for path in files.values():
        if kind(path) not in TABLES:
            raise ConfigError(
                f"group is {group!r}, a column of tables ({', '.join(TABLES)}), but {path.name} is none. Leave group "
                "out, or this file."
            )
    return {
        f"{stem}/{value}": Recording(path, rows)
        for stem, path in files.items()
        for value, rows in grouped(path, group).items()
    }
