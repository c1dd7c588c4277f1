"""Where the files of a proposal go; nothing is written over by accident."""

from pathlib import Path
from typing import NamedTuple

from dr_lab.errors import ConfigError


class Files(NamedTuple):
    """The files of a proposal."""

    xml: Path
    model: Path
    measurements: Path


class Folder:
    """A folder of configurations, for ``--config-dir``.

    Attributes:
        path: the folder.
        name: what model and measurements are called; None takes the description's own.

    Args:
        path: the folder, which need not be there.
        name: as above.
        overwrite: whether files that are there may be replaced.
    """

    def __init__(self, path: str, name: str | None, overwrite: bool) -> None:
        self.path, self.name, self._overwrite = Path(path).expanduser(), name, overwrite

    def files(self, name: str, *, free: bool = True) -> Files:
        """The files of a proposal of a name.

        Args:
            name: of model and measurements.
            free: whether they are yet to be written.

        Raises:
            ConfigError: they are yet to be written, but one is there and may not be replaced.
        """
        model, measurements = self.path / "model", self.path / "measurements" / f"{name}.yaml"
        files = Files(model / f"{name}.xml", model / f"{name}.yaml", measurements)
        there = [str(path) for path in files if path.exists()]
        if free and there and not self._overwrite:
            raise ConfigError(
                f"There is already {', '.join(there)}. Write to another folder (output=FOLDER), under another name "
                "(name=NAME), or replace what is there (overwrite=true)."
            )
        return files
