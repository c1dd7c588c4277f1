"""What a log holds: every series of numbers, with what its file calls it."""

import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa

from dr_lab.errors import ConfigError, DataError
from dr_lab.measurements.log_file import EXPECTED, KINDS, TABLES, kind
from dr_lab.measurements.mcap import McapSource
from dr_lab.measurements.raw_log import TimeAxis, open_source
from dr_lab.measurements.recordings import Recording
from dr_lab.measurements.table import is_list
from dr_lab.measurements.table_file import load

_LEROBOT = Path("meta") / "info.json"  # of a data set as LeRobot writes it


@dataclass(frozen=True)
class Place:
    """Where a log keeps one series of numbers.

    Attributes:
        topic: of an MCAP file or a bag; empty for a table.
        path: field of the topic's messages, or column.
        label: what the file calls the entry of a list, such as a joint's name; empty where it does not.
        clock: ``header``, ``log`` or, of a table, ``column``.
    """

    topic: str
    path: str
    label: str
    clock: str

    def __str__(self) -> str:
        """As messages name it."""
        return f"{self.topic} {self.path}" if self.topic else self.path

    @property
    def entry(self) -> dict[str, str]:
        """How a measurements configuration names it."""
        return {"topic": self.topic, "field": self.path} if self.topic else {"column": self.path}


def messages_of(path: Path) -> tuple[Place, ...]:
    """The numeric fields of all topics of an MCAP file or a bag.

    Raises:
        DataError: the file cannot be read.
    """
    source = open_source(Recording(path), TimeAxis())
    if not isinstance(source, McapSource):
        raise ConfigError(f"{path.name} is a table; expected MCAP files or bags.")
    found = []
    for topic in source.topics:
        fields = source.fields(topic)
        clock = "header" if fields and source.stamped(topic) else "log"
        found += [Place(topic, field.path, field.label, clock) for field in fields]
    return tuple(found)


def columns_of(path: Path) -> tuple[Place, ...]:
    """The numeric columns of a table that have a name of their own, entries of lists one by one.

    Raises:
        DataError: the file cannot be read.
    """
    return tuple(place for name, column in by_name(load(path).table).items() for place in _column(column, name, path))


def by_name(table: pa.Table) -> dict[str, pa.ChunkedArray]:
    """The columns of a table by their names, without those that share a name or have none."""
    count = Counter(table.column_names)
    named = zip(table.column_names, table.columns, strict=True)
    return {name: column for name, column in named if name and count[name] == 1}


def shared_names(path: Path) -> tuple[str, ...]:
    """What is said of the names that several columns of a table share, a sentence each.

    Raises:
        DataError: the file cannot be read.
    """
    counts = Counter(load(path).table.column_names)
    return tuple(
        f"{path.name}: {count} columns are called {name}, so that none of them is read. Give each a name of its own."
        for name, count in counts.items()
        if name and count > 1
    )


def require_one_kind(paths: list[Path]) -> bool:
    """Whether logs are tables; all must be, or none.

    Raises:
        ConfigError: they are of both kinds, or of none.
    """
    for path in paths:
        if kind(path) not in KINDS:
            raise ConfigError(f"{path.name}: {EXPECTED}.")
    tables = [kind(path) in TABLES for path in paths]
    if any(tables) and not all(tables):
        other = next(path for path, table in zip(paths, tables, strict=True) if not table)
        table = next(path for path, table in zip(paths, tables, strict=True) if table)
        raise ConfigError(f"{table.name} is a table and {other.name} is none. Give logs of one kind at a time.")
    return all(tables)


def _column(column: pa.ChunkedArray, name: str, path: Path) -> Iterator[Place]:
    if is_list(column.type):
        if not _is_number(column.type.value_type):
            return
        lengths = {len(entry) for entry in column.slice(0, 1).to_pylist() if entry}
        labels = _lerobot_names(path, name)
        for k in range(max(lengths, default=0)):
            yield Place("", f"{name}[{k}]", labels[k] if k < len(labels) else "", "column")
    elif _is_number(column.type):
        yield Place("", name, "", "column")


def _is_number(kind: pa.DataType) -> bool:
    return pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_decimal(kind)


def _lerobot_names(path: Path, column: str) -> list[str]:
    """What a LeRobot data set calls the entries of a column."""
    file = next((each / _LEROBOT for each in path.absolute().parents if (each / _LEROBOT).is_file()), None)
    if file is None:
        return []
    try:
        names = json.loads(file.read_text(encoding="utf-8"))["features"][column]["names"]
    except (ValueError, KeyError, TypeError) as error:
        raise DataError(
            f"{file} does not say what {column} holds ({error}); expected features.{column}.names."
        ) from error
    if isinstance(names, dict):
        names = next((each for each in names.values() if isinstance(each, list)), [])
    return [str(name) for name in names or []]
