"""What kind of log a file or folder is, and what it is called; a compressed table is a table."""

from pathlib import Path

TABLES = (".csv", ".txt", ".parquet")
BAG = "bag"  # kind of a rosbag2 folder
_COMPRESSED = (".gz", ".bz2", ".zst", ".lz4")
_BAG_FILE = "metadata.yaml"
KINDS = (".mcap", ".db3", BAG, *TABLES)
EXPECTED = (
    f"a log is an .mcap or .db3 file, a rosbag2 folder with {_BAG_FILE}, a .parquet file, or a .csv or .txt file, "
    f"which may be compressed ({', '.join(_COMPRESSED)})"
)


def kind(path: Path) -> str:
    """One of `KINDS`, or another suffix.

    Args:
        path: a file or folder.
    """
    if is_bag(path):
        return BAG
    return path.suffix if path.suffix not in _COMPRESSED else path.with_suffix("").suffix


def stem(path: Path) -> str:
    """What a log is called: its name without the suffixes of its kind; a folder's whole name."""
    if path.is_dir():
        return path.name
    return path.stem if path.suffix not in _COMPRESSED else path.with_suffix("").stem


def is_bag(path: Path) -> bool:
    """Whether a path is a folder that rosbag2 wrote."""
    return (path / _BAG_FILE).is_file()
