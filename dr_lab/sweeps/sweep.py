"""The folder of a sweep: which jobs it has, under which number and in which folder, for good."""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path, PurePath
from typing import Any

from dr_lab.errors import ConfigError
from dr_lab.files import remove_leftovers, why_no_folder, write_text

SWEEP_FILE = "sweep.json"
SCHEMA = "dr_lab/sweep/1"
LOCK_FILE = ".sweep.lock"
STOP_FILE = ".stop"
JOURNAL_FILE = "study.journal"
_RESUME, _STUDY = "resume", "study"
_REMEDY = "Choose another pattern, hydra.sweep.subdir=…, or another folder, hydra.sweep.dir=…"
_DIGITS = 16  # of a job's identity
_NAME_DIGITS = 8  # of a folder's name


@dataclass(frozen=True)
class SweepJob:
    """One job of a sweep.

    Attributes:
        number: it keeps for ever.
        identity: `identity_of` its configuration.
        folder: relative to the sweep's.
        overrides: that make its configuration.
    """

    number: int
    identity: str
    folder: str
    overrides: tuple[str, ...]


def identity_of(configuration: Mapping[str, Any]) -> str:
    """What tells a job from others: the hash of its configuration.

    Args:
        configuration: as composed, interpolations unresolved, without what says where results go.
    """
    text = json.dumps(configuration, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:_DIGITS]


def sweep_name(config_name: str, overrides: Sequence[str]) -> str:
    """Name of the folder of a sweep that is given none: the same for the same command, whenever it is typed.

    The resolver ``${sweep_name:CONFIG,OVERRIDES}``.

    Args:
        config_name: root configuration.
        overrides: as typed, in any order.
    """
    return identity_of({"config": config_name, "overrides": sorted(map(str, overrides))})[:_NAME_DIGITS]


def read_jobs(sweep_dir: Path) -> list[SweepJob]:
    """The jobs of a sweep in order of their numbers; none where nothing was begun.

    Args:
        sweep_dir: folder of the sweep.
    """
    path = sweep_dir / SWEEP_FILE
    if not path.is_file():
        return []
    found = json.loads(path.read_text(encoding="utf-8"))["jobs"]
    return [SweepJob(**{**job, "overrides": tuple(job["overrides"])}) for job in found]


def add_jobs(sweep_dir: Path, verb: str, sweeper: str, jobs: Sequence[SweepJob]) -> None:
    """Write jobs down beside those that the sweep has, before any of them begins.

    Args:
        sweep_dir: folder of the sweep, which this process holds.
        verb: what the jobs run.
        sweeper: option of ``hydra/sweeper`` that numbers them.
        jobs: new ones.

    Raises:
        ConfigError: a job's folder is or lies in that of another one, or outside of the sweep's, or holds something
            else.
        DrLabError: the folder cannot be written.
    """
    every = sorted([*read_jobs(sweep_dir), *jobs], key=lambda job: job.number)
    _require_apart(sweep_dir, every)
    for job in jobs:
        _require_own_folder(sweep_dir, job)
    listed = [asdict(job) for job in every]
    content = {"schema": SCHEMA, "verb": verb, "sweeper": sweeper, "jobs": listed}
    write_text(sweep_dir / SWEEP_FILE, json.dumps(content, ensure_ascii=False, indent=1) + "\n")


def _sweeper_of(sweep_dir: Path) -> str | None:
    """The sweeper whose jobs a folder holds, or None where nothing was begun."""
    path = sweep_dir / SWEEP_FILE
    listed = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    if "sweeper" in listed:
        return listed["sweeper"]
    # Nothing is listed yet, or by a version of dr_lab that did not say whose jobs they are.
    if (sweep_dir / JOURNAL_FILE).is_file():
        return _STUDY
    return _RESUME if listed else None


def _require_own_folder(sweep_dir: Path, job: SweepJob) -> None:
    path, folder = PurePath(job.folder), sweep_dir / job.folder
    if path.is_absolute() or ".." in path.parts or not path.parts:
        raise ConfigError(
            f"hydra.sweep.subdir puts job {job.number} into {job.folder!r}, outside of {sweep_dir}. {_REMEDY}"
        )
    if folder.is_dir() and any(folder.iterdir()):
        raise ConfigError(f"{folder} holds something that is not of this sweep. {_REMEDY}")


def _require_apart(sweep_dir: Path, jobs: Sequence[SweepJob]) -> None:
    """Refuse folders that lie in one another: a job that starts over empties its own."""
    # In this order a folder stands right behind one that holds it, or behind another that this one holds.
    folders = sorted((PurePath(job.folder).parts, job.number) for job in jobs)
    for (outer, first), (inner, second) in pairwise(folders):
        path = sweep_dir.joinpath(*inner)
        if inner == outer:
            raise ConfigError(f"{path} would be the folder of jobs {first} and {second}. {_REMEDY}")
        if inner[: len(outer)] == outer:
            raise ConfigError(f"{path} would be the folder of job {second} and lie in that of job {first}. {_REMEDY}")


@contextmanager
def only_driver(sweep_dir: Path, sweeper: str) -> Iterator[None]:
    """Hold a sweep's folder, which is made, so that one command at a time drives it; a killed one holds nothing.

    Args:
        sweep_dir: folder of the sweep.
        sweeper: option of ``hydra/sweeper`` that the command uses.

    Raises:
        ConfigError: another command drives a sweep there, the sweep is another sweeper's, or the folder cannot be made.
    """
    from filelock import FileLock, Timeout  # noqa: PLC0415  takes a tenth of a second, which every command would pay

    try:
        sweep_dir.mkdir(parents=True, exist_ok=True)
        lock = FileLock(sweep_dir / LOCK_FILE, blocking=False)
        lock.acquire()
    except Timeout:
        message = (
            f"Another command runs a sweep in {sweep_dir}. Wait for it, or choose another folder: hydra.sweep.dir=…"
        )
        raise ConfigError(message) from None
    except OSError as error:
        raise ConfigError(
            f"Cannot make the sweep's folder {sweep_dir}: {why_no_folder(sweep_dir, error)}. Choose another place: "
            "outputs=FOLDER, or hydra.sweep.dir=FOLDER if you gave that."
        ) from error
    try:
        found = _sweeper_of(sweep_dir)
        if found not in (None, sweeper):
            raise ConfigError(
                f"The sweep in {sweep_dir} was begun with hydra/sweeper={found}, not {sweeper}, and numbers its jobs "
                "in its own way. Keep that sweeper, or choose another folder: hydra.sweep.dir=…"
            )
        (sweep_dir / STOP_FILE).unlink(missing_ok=True)
        remove_leftovers(sweep_dir)
        yield
    finally:
        lock.release()


def stop(sweep_dir: Path, reason: str) -> None:
    """Let no further job of a sweep begin until the next command.

    Args:
        sweep_dir: folder of the sweep.
        reason: why.
    """
    write_text(sweep_dir / STOP_FILE, reason + "\n")


def is_stopped(sweep_dir: Path) -> bool:
    """Whether jobs that have not begun are to be left.

    Args:
        sweep_dir: folder of the sweep.
    """
    return (sweep_dir / STOP_FILE).exists()
