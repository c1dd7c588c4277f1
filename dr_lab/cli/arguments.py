"""The arguments of a verb's function: its configuration composed, checked and built."""

import copy
import importlib
import inspect
import re
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any

from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf

from dr_lab.cli.check import check
from dr_lab.cli.compose import compose_from, register_resolvers
from dr_lab.cli.groups import misplaced, options
from dr_lab.cli.positional import KEY as POSITIONAL
from dr_lab.cli.positional import root_text
from dr_lab.errors import ConfigError
from dr_lab.run_command import CONFIG_FILE

# Keys of a configuration that are not a workflow's business, unless it asks for them.
COMMAND_LINE_KEYS = ("outputs", "made_with", POSITIONAL)
# Parameter of a workflow that can go on with an earlier run's folder.
RESUME = "resume"
# Parameters of a workflow that the command line gives, not the configuration.
RUN_DIR = "run_dir"
COMPOSE = "compose"
SUPPLIED = (RUN_DIR, COMPOSE)


def compose_arguments(
    verb: str,
    overrides: Sequence[str],
    folders: Sequence[Path],
    recorded: Path | None = None,
    only: Collection[str] | None = None,
) -> dict[str, Any]:
    """What a command line would call a verb's function with, its run folder apart.

    Args:
        verb: e.g. ``"diagnose"``.
        overrides: as on the command line.
        folders: configuration folders, first searched first; the last one ships with dr_lab.
        recorded: run folder of that verb, whose configuration is taken instead of the verb's own.
        only: the arguments that are wanted, whatever else the configuration holds; None for all.

    Raises:
        ConfigError: the configuration cannot be run.
        hydra.errors.ConfigCompositionException: an override names nothing.
    """
    if recorded is None:
        cfg = compose_from(folders, verb, overrides)
    else:
        cfg = compose_from((recorded.absolute(), *folders), Path(CONFIG_FILE).stem, overrides)
    return arguments_of(verb, cfg, folders, only=only)[1]


def arguments_of(
    verb: str,
    cfg: DictConfig,
    folders: Sequence[Path],
    given: Collection[str] = (),
    only: Collection[str] | None = None,
) -> tuple[Callable[..., Any], dict[str, Any]]:
    """A verb's function and the arguments that its configuration gives.

    Nothing is built before the whole configuration is found sound.

    Args:
        verb: its name.
        cfg: its composed configuration without Hydra's node.
        folders: configuration folders, first searched first.
        given: keys that the caller has built already.
        only: as for `compose_arguments`.

    Raises:
        ConfigError: the configuration cannot be run.
    """
    workflow, passed = checked(verb, cfg, folders, only)
    # One key at a time: what only feeds another key is built there, and only there. Building resolves interpolations in
    # place, which are still to be recorded as they are.
    wanted = {str(key): value for key, value in copy.deepcopy(cfg).items() if key in passed - {*given}}
    return workflow, {k: instantiate(v, _convert_="all") if OmegaConf.is_config(v) else v for k, v in wanted.items()}


def checked(
    verb: str, cfg: DictConfig, folders: Sequence[Path], only: Collection[str] | None = None
) -> tuple[Callable[..., Any], set[str]]:
    """A verb's function and the keys that it is given, when the configuration is found sound; nothing is built.

    Args:
        verb: its name.
        cfg: its composed configuration without Hydra's node.
        folders: configuration folders, first searched first.
        only: as for `compose_arguments`.

    Raises:
        ConfigError: the configuration cannot be run.
    """
    register_resolvers(folders)
    workflow = workflow_of(verb)
    parameters = inspect.signature(workflow).parameters
    unused = (
        not_passed(cfg, parameters, root_text(verb, folders)) if only is None else {str(key) for key in cfg} - {*only}
    )
    supplied = SUPPLIED if only is None else {*parameters} - {*only}
    _require_placed(cfg, folders)
    check(cfg, workflow, verb, supplied, unused)
    return workflow, {str(key) for key in cfg} - unused


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


def not_passed(cfg: DictConfig, parameters: Collection[str], root: str = "") -> set[str]:
    """Top-level keys that are no parameter of the workflow and need not be.

    Those are the command line's own, and those that only feed other keys: ``seed`` where it stands in ``${seed}``, also
    where the user has given what it would have fed (``folder.path=…`` in place of ``output=…``).

    Args:
        cfg: composed configuration without Hydra's node.
        parameters: names of the workflow's parameters.
        root: the verb's own root configuration as it is written.
    """
    text = f"{OmegaConf.to_yaml(cfg, resolve=False)}\n{root}"
    fed = {str(key) for key in cfg if re.search(rf"\$\{{{re.escape(str(key))}[.}}]", text)}
    return {*COMMAND_LINE_KEYS, *fed} - set(parameters)


def _require_placed(cfg: DictConfig, folders: Sequence[Path]) -> None:
    """Refuse an option that lies at its group's key, though its neighbours stand side by side below another."""
    for group in cfg:
        node = cfg._get_node(group)  # values may be missing or lead nowhere, which is said later
        if isinstance(node, DictConfig) and "_target_" in node:
            for fault in misplaced(options(str(group), folders)).values():
                raise ConfigError(fault)
