"""How far a run's climbs have come, in files from which another run goes on to the same end.

A file holds a line that tells what it belongs to, and a pickle. In the place of what the other run makes anew, such as
the model and the windows, it holds their names. Only classes of dr_lab and arrays are read, no other code is run.
"""

import hashlib
import json
import pickle
import shutil
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from dr_lab.comparison.study import Study
from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.search.climb import Climb
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.errors import ConfigError, DataError
from dr_lab.files import atomic
from dr_lab.physics.compiled_contexts import packed
from dr_lab.physics.model import Model
from dr_lab.trajectory import Log
from dr_lab.version import __version__

UNFINISHED = "unfinished"  # folder of a run
_PLAIN = {
    "builtins": {"set", "frozenset", "slice", "complex"},
    "numpy": {"ndarray", "dtype"},
    "numpy._core.multiarray": {"_reconstruct", "scalar"},
    "numpy._core.numeric": {"_frombuffer"},
    "types": {"MappingProxyType"},
    "pathlib": {"Path", "PosixPath", "WindowsPath"},
}
# What is raised for a file that is damaged, or was written by another version.
_DAMAGED = (OSError, EOFError, pickle.UnpicklingError, AttributeError, ImportError, LookupError, TypeError, ValueError)


@dataclass(frozen=True)
class Reached:
    """How far the climb in windows of one length has come.

    Attributes:
        base: the calibrated model.
        climb: where it goes on; None before its first rung is judged.
        ladder: where it ended; None before.
    """

    base: FittedModel
    climb: Climb | None = None
    ladder: Ladder | None = None


class KeptClimbs:
    """How far the climbs of one run have come, by the length of their windows.

    Args:
        folder: the run folder; None keeps nothing.
        earlier: run folder to go on with; None for none.

    Raises:
        ConfigError: the earlier run has nothing to go on with.
    """

    def __init__(self, folder: Path | None = None, earlier: Path | None = None) -> None:
        self._folder = None if folder is None else folder / UNFINISHED
        self._earlier = None if earlier is None else earlier / UNFINISHED
        self._known: dict[float, Reached] = {}
        if self._earlier is not None and not self._earlier.is_dir():
            raise ConfigError(
                f"resume={earlier} has nothing to go on with: it came to its end, which report.md tells, or was "
                "interrupted before the model was calibrated. Start a new run, without resume."
            )

    @property
    def begun(self) -> bool:
        """Whether anything is kept."""
        return bool(self._known)

    def reached(self, study: Study) -> Reached | None:
        """How far the climb in a study's windows has come, in this run or the earlier one; None where nowhere.

        Raises:
            DataError: the earlier run had other logs or another model, or its file cannot be read.
        """
        length = study.settings.windows.length
        if length not in self._known and self._earlier is not None and _file(self._earlier, length).is_file():
            self.keep(study, _read(_file(self._earlier, length), study))
        return self._known.get(length)

    def keep(self, study: Study, reached: Reached) -> None:
        """Remember how far the climb in a study's windows has come.

        Raises:
            DrLabError: the file cannot be written.
        """
        length = study.settings.windows.length
        self._known[length] = reached
        if self._folder is not None:
            with atomic(_file(self._folder, length)) as temporary, temporary.open("wb") as file:
                file.write(json.dumps(_belongs(study)).encode() + b"\n")
                _Pickler(file, study).dump(reached)

    def clear(self) -> None:
        """Remove the run's files: it came to its end."""
        if self._folder is not None and self._folder.is_dir():
            shutil.rmtree(self._folder)


def _file(folder: Path, length: float) -> Path:
    return folder / f"windows_of_{length:.6g}_s.pickle"


def _read(path: Path, study: Study) -> Reached:
    remedy = "Start a new run, without resume."
    with path.open("rb") as file:
        if changed := _changed(file.readline(), study):
            raise DataError(f"{path} is no use any more: since then {changed}. {remedy}")
        try:
            found = _Unpickler(file, study).load()
        except _DAMAGED as error:
            raise DataError(f"Cannot read {path}: it is damaged or cut short ({error}). {remedy}") from error
    assert isinstance(found, Reached)
    return found


def _belongs(study: Study) -> dict[str, str]:
    """What tells the version, the model and each log from others, by what it is called."""
    logs = (*study.measurements.fit, *study.measurements.held_out)
    model = hashlib.sha256(packed(study.compiled).tobytes()).hexdigest()
    return {"dr_lab": __version__, "the model file": model} | {f"log {log.name}": _digest(log) for log in logs}


def _digest(log: Log) -> str:
    told = hashlib.sha256()
    for signal in (*log.outputs.values(), *log.commands.values()):
        told.update(f"{signal.name}/{signal.between}".encode())
        told.update(np.ascontiguousarray(signal.time).tobytes())
        told.update(np.ascontiguousarray(signal.value).tobytes())
    return told.hexdigest()


def _changed(line: bytes, study: Study) -> str:
    """What differs from what a file's first line tells, in words; empty where nothing does."""
    now = _belongs(study)
    try:
        then = dict(json.loads(line))
    except ValueError:
        return "its first line was changed"
    different = [name for name in {**then, **now} if then.get(name) != now.get(name)]
    return f"{', '.join(different)} changed" if different else ""


def _shared(study: Study) -> dict[str, object]:
    """What a run makes anew, by name."""
    bench = study.bench
    windows = {"fit": bench.fit, "held_out": bench.held_out, "confirms": bench.confirms}
    named = {"spec": study.model.spec, "model": study.model, "bench": bench, **windows}
    return {name: each for name, each in named.items() if each is not None}


class _Pickler(pickle.Pickler):
    def __init__(self, file: BinaryIO, study: Study) -> None:
        super().__init__(file, protocol=5)
        self._names = {id(each): name for name, each in _shared(study).items()}

    def persistent_id(self, obj: object) -> str | None:
        return self._names.get(id(obj))

    def reducer_override(self, obj: object) -> Any:  # noqa: ANN401 (pickle's own type of it is private)
        """A model without what it computed once, which holds specs."""
        if not isinstance(obj, Model):
            return NotImplemented
        return type(obj), tuple(getattr(obj, each.name) for each in fields(obj))


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: BinaryIO, study: Study) -> None:
        super().__init__(file)
        self._shared = _shared(study)

    def persistent_load(self, pid: str) -> object:
        return self._shared[pid]

    def find_class(self, module: str, name: str) -> object:
        if module.partition(".")[0] == "dr_lab" or name in _PLAIN.get(module, ()):
            return super().find_class(module, name)
        raise pickle.UnpicklingError(f"it names {module}.{name}")
