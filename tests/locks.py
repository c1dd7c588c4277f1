"""The lock files, and what they pin as libraries that stand apart from the others of this environment."""

import re
from importlib.metadata import distribution
from pathlib import Path

ROOT = Path(__file__).parents[1]
EVERYTHING, COMPARING = ROOT / "requirements.lock", ROOT / "requirements-compare.lock"


def pins(lock: Path) -> set[str]:
    """The requirements of a lock file, each as it stands there: name, version, marker and hashes."""
    lines = [line for line in lock.read_text(encoding="utf-8").splitlines() if not line.lstrip().startswith("#")]
    return set(re.split(r"\n(?=\S)", "\n".join(lines)))


def names(lock: Path) -> set[str]:
    """The libraries that a lock file pins."""
    return {pin.partition("==")[0] for pin in pins(lock)}


def link(lock: Path, folder: Path) -> Path:
    """Put the libraries that a lock file pins into a folder, and no other one, as links to this environment's."""
    folder.mkdir()
    for name in names(lock):
        found = distribution(name)
        for top in {file.parts[0] for file in found.files or ()} - {"..", "__pycache__"}:
            if not (folder / top).exists():
                (folder / top).symlink_to(str(found.locate_file(top)))
    return folder
