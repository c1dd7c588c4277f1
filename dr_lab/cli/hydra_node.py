"""Hydra's own node, which Hydra builds from before it calls anything of ours: checked as the rest of a configuration.

An experiment or a run folder of someone else's may set it, too.
"""

import inspect
import logging
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import wraps

from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra.core.config_store import ConfigStore
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.errors import HydraException
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from dr_lab.cli.check import INSTRUCTIONS, check_targets
from dr_lab.cli.place import Place
from dr_lab.cli.targets import locate
from dr_lab.errors import ConfigError

BUILT = ("callbacks",)
BUILT_FOR_A_SWEEP = (*BUILT, "sweeper", "launcher")
LOGS = ("hydra_logging", "job_logging")
LOGGING_CALLS = ("()", "class")  # keys whose value the standard library's logging calls
LOGGING_PACKAGES = ("logging", "colorlog")
LOGGING_CLASSES = (logging.Handler, logging.Formatter, logging.Filter)


_ONE_RUN = "hydra.mode=RUN"  # what Hydra adds to the overrides once it knows that nothing is swept


@contextmanager
def checked_at_composition() -> Iterator[None]:
    """Check Hydra's node of whatever is composed during a block, a sweep's jobs included; compose nothing twice."""
    # Hydra 1.3 has no public hook between composing and calling: a Callback is itself built from what was composed,
    # after logging was configured by it. To compose once more beforehand takes 0.3 s for dr-lab close, and misses what
    # flags change and what a sweep's jobs compose.
    load, kept = ConfigLoaderImpl.load_configuration, list[tuple[str | None, list[str], DictConfig]]()

    @wraps(load)
    def checked(
        self: ConfigLoaderImpl,
        config_name: str | None,
        overrides: list[str],
        run_mode: RunMode,
        from_shell: bool = True,
        validate_sweep_overrides: bool = True,
    ) -> DictConfig:
        if not validate_sweep_overrides and not _sweeps(overrides):  # Hydra only looks for its mode
            cfg = load(self, config_name, overrides, RunMode.RUN, from_shell, validate_sweep_overrides=False)
            kept[:] = [(config_name, [*overrides, _ONE_RUN], cfg)]
            return cfg
        if kept and kept[0][:2] == (config_name, overrides):
            cfg = kept.pop()[2]
            cfg.hydra.mode = RunMode.RUN
            cfg.hydra.overrides.hydra.append(_ONE_RUN)
        else:
            cfg = load(self, config_name, overrides, run_mode, from_shell, validate_sweep_overrides)
        if validate_sweep_overrides:  # else what is wrong is dropped
            check_hydra(cfg)
            _check_folders(cfg)
        return cfg

    ConfigLoaderImpl.load_configuration = checked
    try:
        yield
    finally:
        ConfigLoaderImpl.load_configuration = load


def _sweeps(overrides: list[str]) -> bool:
    """Whether an override gives several values; those that cannot be read are told when all is composed."""
    try:
        return any(each.is_sweep_override() for each in OverridesParser.create().parse_overrides(overrides))
    except HydraException:
        return True


def check_hydra(cfg: DictConfig) -> None:
    """Check what Hydra will build.

    Args:
        cfg: a configuration with Hydra's node.

    Raises:
        DrLabError: a target is not trusted or cannot be built, or a setting is missing, unknown or of the wrong type.
        omegaconf.errors.OmegaConfBaseException: an interpolation leads nowhere, or a mandatory value is missing.
    """
    parts = BUILT_FOR_A_SWEEP if cfg.hydra.mode == RunMode.MULTIRUN else BUILT
    for part in parts:
        value = _plain(cfg, part)
        check_targets(value, Place(f"hydra.{part}"))
        if part == "launcher":
            _check_stock(value)
    for part in LOGS:
        _check_logging(cfg.hydra[part], f"hydra.{part}")


def _check_folders(cfg: DictConfig) -> None:
    """Refuse folders of results without a name; in the others ``~`` is the user's home, as in all that are given.

    Hydra takes null for a folder called None, and no name for the one where the user is.
    """
    for node, key, name in (
        (cfg, "outputs", "outputs"),
        (cfg.hydra.run, "dir", "hydra.run.dir"),
        (cfg.hydra.sweep, "dir", "hydra.sweep.dir"),
    ):
        given = OmegaConf.to_container(OmegaConf.masked_copy(node, [key]), resolve=False)
        assert isinstance(given, dict)
        if key not in given:
            continue
        folder = given[key]
        if not folder:
            told = "null" if folder is None else "empty"
            raise ConfigError(f"{name} is {told}; expected a folder. Give {name}=FOLDER, or leave it out.")
        if str(folder).startswith("~"):
            node[key] = os.path.expanduser(folder)


def _plain(cfg: DictConfig, part: str) -> object:
    node = cfg.hydra[part]
    return OmegaConf.to_container(node, resolve=True, throw_on_missing=True) if OmegaConf.is_config(node) else node


def _check_stock(launcher: object) -> None:
    """Check a launcher of Hydra's own plugins, which takes any keyword, against the settings that its package knows."""
    if not isinstance(launcher, Mapping):
        return
    given = {key: value for key, value in launcher.items() if key not in INSTRUCTIONS}
    for stored in ConfigStore.instance().repo["hydra"]["launcher"].values():
        if stored.node.get("_target_") == launcher.get("_target_"):
            try:
                OmegaConf.merge(stored.node, given)
            except OmegaConfBaseException as error:
                text = (error.msg or str(error)).splitlines()[0]
                raise ConfigError(f"hydra.launcher.{error.full_key}: {text}") from error


def _check_logging(node: object, path: str) -> None:
    """Check what the standard library's logging would call, which is anything that a configuration names."""
    if not isinstance(node, DictConfig):  # what lies in a list is never called
        return
    for key in node:
        try:
            child = node[key]
        except OmegaConfBaseException:
            if key in LOGGING_CALLS:
                raise
            continue  # a text that is known when a job runs, such as its folder
        if key in LOGGING_CALLS:
            found = locate(str(child), path, LOGGING_PACKAGES)
            if not inspect.isclass(found) or not issubclass(found, LOGGING_CLASSES):
                raise ConfigError(f"{path}: {child!r} is no handler, formatter or filter of logging.")
        _check_logging(child, f"{path}.{key}")
