"""One job: a composed configuration is checked, built, given a folder and handed to its workflow."""

import contextlib
import functools
import inspect
import itertools
import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from omegaconf import DictConfig

from dr_lab.cli.arguments import COMPOSE, RESUME, RUN_DIR, arguments_of, compose_arguments, workflow_of
from dr_lab.cli.provenance import write_config
from dr_lab.cli.resuming import require_same_settings
from dr_lab.cli.threads import algebra_on_one_thread
from dr_lab.errors import ConfigError, DrLabError
from dr_lab.reports.typed import view_command
from dr_lab.run_command import CONFIG_FILE
from dr_lab.stopping import stop_if_asked


@dataclass(frozen=True)
class Job:
    """What a job is besides its configuration.

    Attributes:
        verb: e.g. ``"close"``.
        overrides: what the user typed after it.
        base: option of the group ``base`` that its root configuration builds on, or None.
        output_dir: the folder that Hydra made for it.
        folders: configuration folders, first searched first.
        resume: run folder of an earlier attempt to go on with, or None; comes before what the configuration says.
    """

    verb: str
    overrides: tuple[str, ...]
    base: str | None
    output_dir: Path
    folders: tuple[Path, ...]
    resume: Path | None = None


def can_go_on(job: Job) -> bool:
    """Whether a job's folder holds enough of an earlier attempt for its verb to go on with.

    A workflow that takes `resume` says in `RESUMES_FROM`, beside it, which file or folder that is.

    Args:
        job: which one.

    Raises:
        ConfigError: there is no such verb.
    """
    workflow = workflow_of(job.verb)
    if RESUME not in inspect.signature(workflow).parameters:
        return False
    return (job.output_dir / sys.modules[workflow.__module__].RESUMES_FROM).exists()


def run_job(job: Job, cfg: DictConfig) -> None:
    """Check, build and run.

    Nothing is built before the whole configuration is found sound, and a job that fails before its work starts, or
    is refused before it left anything, leaves no folder behind.

    Args:
        job: which one.
        cfg: its composed configuration without Hydra's node.

    Raises:
        ConfigError: the configuration cannot be run.
        DrLabError: whatever the workflow reports.
    """
    try:
        workflow, arguments = build(job, cfg)
        stop_if_asked()
    except BaseException:
        discard(job.output_dir, cfg)
        raise
    if RUN_DIR in arguments and arguments[RUN_DIR] != job.output_dir:
        _tell_other_folder(job.output_dir, arguments[RUN_DIR], arguments.get(RESUME))
    try:
        with algebra_on_one_thread():
            workflow(**arguments)
    except DrLabError:
        if RUN_DIR in arguments and [path.name for path in arguments[RUN_DIR].iterdir()] == [CONFIG_FILE]:
            (arguments[RUN_DIR] / CONFIG_FILE).unlink()
            discard(arguments[RUN_DIR], cfg)
        raise
    stop_if_asked()
    if RUN_DIR in arguments:
        _tell_files(_shortest(arguments[RUN_DIR]))


def _tell_other_folder(wanted: Path, taken: Path, earlier: str | None) -> None:
    same = earlier is not None and Path(earlier).expanduser().absolute() == wanted.absolute()
    holds = "holds the run that is gone on with" if same else "holds another run"
    print(f"{_shortest(wanted)} {holds}; this one goes to {_shortest(taken)}.\n")


def _tell_files(folder: Path) -> None:
    print(f"\nRun folder: {folder}")
    if (folder / "report.html").exists():
        print(f"Report to send: {folder / 'report.html'}")
    if (folder / "review.rrd").exists():
        print(f"Look at it: {view_command(folder)}")


def build(job: Job, cfg: DictConfig) -> tuple[Callable[..., Any], dict[str, Any]]:
    """The workflow and the keyword arguments it will be called with; its run folder exists and holds ``config.yaml``.

    A workflow that goes on only with a run of the same settings says in `MAY_DIFFER`, beside it, which keys are none.

    Args:
        job: which one.
        cfg: its composed configuration without Hydra's node.

    Raises:
        ConfigError: the configuration cannot be run.
    """
    workflow, arguments = arguments_of(job.verb, cfg, job.folders)
    parameters = inspect.signature(workflow).parameters
    if job.resume is not None:
        arguments[RESUME] = str(job.resume)  # of a job that is known by its configuration, which is therefore the same
    elif arguments.get(RESUME) is not None and hasattr(sys.modules[workflow.__module__], "MAY_DIFFER"):
        earlier = Path(arguments[RESUME]).expanduser()
        require_same_settings(cfg, earlier, job.verb, sys.modules[workflow.__module__].MAY_DIFFER)
    if COMPOSE in parameters:
        arguments[COMPOSE] = functools.partial(compose_arguments, folders=job.folders)
    if RUN_DIR in parameters:
        arguments[RUN_DIR] = claim(job.output_dir)
        write_config(arguments[RUN_DIR], job.verb, job.overrides, job.base, cfg, job.folders[:-1])
    return workflow, arguments


def claim(output_dir: Path) -> Path:
    """Make a folder this run's own; where another run has it, the next free of ``<name>_2``, ``<name>_3`` and so on.

    Two runs may start within the same second, or a folder may be named by hand: nothing is ever written over.

    Args:
        output_dir: the wanted folder.

    Raises:
        ConfigError: the folder cannot be written.
    """
    for folder in numbered(output_dir):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / CONFIG_FILE).touch(exist_ok=False)
        except FileExistsError:
            continue
        except OSError as error:
            message = f"Cannot write to {folder}: {error.strerror}. Choose another place: outputs=…"
            raise ConfigError(message) from error
        return folder
    raise AssertionError("counting does not end")


def numbered(folder: Path) -> Iterator[Path]:
    """A folder, then ``<name>_2``, ``<name>_3`` and so on beside it, without end.

    Args:
        folder: the wanted one.
    """
    yield folder
    for number in itertools.count(2):
        yield folder.with_name(f"{folder.name}_{number}")


def discard(folder: Path, cfg: DictConfig) -> None:
    """Remove a run's folder and, up to but not including `outputs`, those above it, as far as they hold nothing else.

    Args:
        folder: as Hydra spells it.
        cfg: the run's composed configuration without Hydra's node.
    """
    top = Path(os.path.abspath(str(cfg.get("outputs", "."))))  # as Hydra spells the job's folder, without ".."
    inside = [path for path in folder.parents if path.is_relative_to(top) and path != top]
    with contextlib.suppress(OSError):  # the first that is not empty ends it
        for path in (folder, *inside):
            path.rmdir()


def _shortest(folder: Path) -> Path:
    return folder.relative_to(Path.cwd()) if folder.is_relative_to(Path.cwd()) else folder
