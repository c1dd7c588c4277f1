"""One job: a composed configuration is checked, built, given a folder and handed to its workflow."""

import contextlib
import importlib
import inspect
import itertools
import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf

from dr_lab.cli.check import check
from dr_lab.cli.compose import misplaced, options, register_resolvers
from dr_lab.cli.provenance import CONFIG_FILE, write_config
from dr_lab.errors import ConfigError

# Keys of a configuration that are not a workflow's business, unless it asks for them.
COMMAND_LINE_KEYS = ("outputs", "made_with")
RUN_DIR = "run_dir"


@dataclass(frozen=True)
class Job:
    """What a job is besides its configuration.

    Attributes:
        verb: e.g. ``"close"``.
        overrides: what the user typed after it.
        base: option of the group ``base`` that its root configuration builds on, or None.
        output_dir: the folder that Hydra made for it.
        folders: configuration folders, first searched first.
    """

    verb: str
    overrides: tuple[str, ...]
    base: str | None
    output_dir: Path
    folders: tuple[Path, ...]


def workflow_of(verb: str) -> Callable[..., Any]:
    """The function that does a verb's work, `dr_lab.workflows.<verb>.<verb>`.

    Raises:
        ConfigError: there is no such function.
    """
    name = f"dr_lab.workflows.{verb}"
    try:
        return getattr(importlib.import_module(name), verb)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        raise ConfigError(f"dr-lab {verb} has a configuration but no workflow: {name} does not exist.") from error


def run_job(job: Job, cfg: DictConfig) -> None:
    """Check, build and run.

    Nothing is built before the whole configuration is found sound, and a job that fails before its work starts
    leaves no folder behind.

    Args:
        job: which one.
        cfg: its composed configuration without Hydra's node.

    Raises:
        ConfigError: the configuration cannot be run.
        DrLabError: whatever the workflow reports.
    """
    try:
        workflow, arguments = build(job, cfg)
    except BaseException:
        _remove_if_empty(job.output_dir, Path(str(cfg.get("outputs", "."))).absolute())
        raise
    workflow(**arguments)
    if RUN_DIR in arguments:
        print(f"\nRun folder: {_shortest(arguments[RUN_DIR])}")


def build(job: Job, cfg: DictConfig) -> tuple[Callable[..., Any], dict[str, Any]]:
    """The workflow and the keyword arguments it will be called with; its run folder exists and holds ``config.yaml``.

    Args:
        job: which one.
        cfg: its composed configuration without Hydra's node.

    Raises:
        ConfigError: the configuration cannot be run.
    """
    register_resolvers(job.folders)
    workflow = workflow_of(job.verb)
    parameters = inspect.signature(workflow).parameters
    unused = not_passed(cfg, parameters)
    _require_placed(cfg, job.folders)
    check(cfg, workflow, job.verb, supplied=(RUN_DIR,), unused=unused)
    # One key at a time: what only feeds another key is built there, and only there.
    wanted = {str(key): value for key, value in cfg.items() if key not in unused}
    arguments = {k: instantiate(v, _convert_="all") if OmegaConf.is_config(v) else v for k, v in wanted.items()}
    if RUN_DIR in parameters:
        arguments[RUN_DIR] = claim(job.output_dir)
        write_config(arguments[RUN_DIR], job.verb, job.overrides, job.base, cfg)
    return workflow, arguments


def not_passed(cfg: DictConfig, parameters: Collection[str]) -> set[str]:
    """Top-level keys that are no parameter of the workflow and need not be.

    Those are the command line's own, and those that only feed other keys: ``seed`` where it stands in ``${seed}``.

    Args:
        cfg: composed configuration without Hydra's node.
        parameters: names of the workflow's parameters.
    """
    text = OmegaConf.to_yaml(cfg, resolve=False)
    fed = {str(key) for key in cfg if re.search(rf"\$\{{{re.escape(str(key))}[.}}]", text)}
    return {*COMMAND_LINE_KEYS, *fed} - set(parameters)


def _require_placed(cfg: DictConfig, folders: Sequence[Path]) -> None:
    """Refuse an option that lies at its group's key, though its neighbours stand side by side below another."""
    for group in cfg:
        node = cfg._get_node(group)  # values may be missing or lead nowhere, which is said later
        if isinstance(node, DictConfig) and "_target_" in node:
            for fault in misplaced(options(str(group), folders)).values():
                raise ConfigError(fault)


def claim(output_dir: Path) -> Path:
    """Make a folder this run's own; where another run has it, the next free of ``<name>_2``, ``<name>_3`` and so on.

    Two runs may start within the same second, or a folder may be named by hand: nothing is ever written over.

    Args:
        output_dir: the wanted folder.

    Raises:
        ConfigError: the folder cannot be written.
    """
    for number in itertools.count(1):
        folder = output_dir if number == 1 else output_dir.with_name(f"{output_dir.name}_{number}")
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


def _remove_if_empty(folder: Path, top: Path) -> None:
    """Remove a folder and, up to but not including `top`, the folders above it that hold nothing else."""
    inside = [path for path in folder.parents if path.is_relative_to(top) and path != top]
    with contextlib.suppress(OSError):  # the first that is not empty ends it
        for path in (folder, *inside):
            path.rmdir()


def _shortest(folder: Path) -> Path:
    return folder.relative_to(Path.cwd()) if folder.is_relative_to(Path.cwd()) else folder
