"""Composing a verb's configuration: the search path, the resolvers and the chosen options."""

import functools
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import ClassVar

import hydra
from hydra.core.config_search_path import ConfigSearchPath
from hydra.core.global_hydra import GlobalHydra
from hydra.core.plugins import Plugins
from hydra.plugins.search_path_plugin import SearchPathPlugin
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from dr_lab.cli import folders as places
from dr_lab.cli.found_formula import found_formula
from dr_lab.cli.groups import every
from dr_lab.cli.overrides import composed
from dr_lab.cli.recorded import recorded
from dr_lab.errors import ConfigError
from dr_lab.sweeps.sweep import sweep_name

HYDRA_VERSION = "1.3"
INTERNAL_GROUPS = ("base", "hydra")


class UserFoldersFirst(SearchPathPlugin):
    """Puts the user's configuration folders before the one that ships with dr_lab.

    Attributes:
        folders: the user's folders, first searched first.
    """

    folders: ClassVar[tuple[Path, ...]] = ()

    def manipulate_search_path(self, search_path: ConfigSearchPath) -> None:
        """Insert the folders; Hydra calls this for every composition."""
        for folder in self.folders:
            search_path.prepend(provider="user", path=f"file://{folder}", anchor="main")


def register_resolvers(folders: Sequence[Path]) -> None:
    """Make ``${conf:…}`` and our other resolvers known to OmegaConf, in every process that needs them.

    Args:
        folders: configuration folders, first searched first.
    """
    OmegaConf.register_new_resolver("conf", functools.partial(places.find, tuple(folders)), replace=True)
    OmegaConf.register_new_resolver("every", lambda group: OmegaConf.create(every(group, folders)), replace=True)
    OmegaConf.register_new_resolver("examples", places.example, replace=True)
    OmegaConf.register_new_resolver("found_formula", found_formula, replace=True)
    OmegaConf.register_new_resolver("recorded", recorded, replace=True)
    OmegaConf.register_new_resolver("sweep_name", sweep_name, replace=True)


def prepare(folders: Sequence[Path]) -> None:
    """Make Hydra compose from the given folders in this process.

    Args:
        folders: configuration folders, first searched first; the last one ships with dr_lab.
    """
    register_resolvers(folders)
    UserFoldersFirst.folders = tuple(folders[:-1])
    Plugins.instance().register(UserFoldersFirst)


def compose(verb: str, overrides: Sequence[str] = (), config_dir: Path | None = None) -> DictConfig:
    """A verb's configuration, for notebooks and tests.

    Args:
        verb: e.g. ``"close"``.
        overrides: as on the command line, e.g. ``["model=furuta", "seed=3"]``.
        config_dir: folder with the user's own groups, searched first.

    Raises:
        hydra.errors.ConfigCompositionException: an override names nothing.
    """
    own = () if config_dir is None else (config_dir.absolute(),)
    return compose_from((*own, places.shipped()), verb, overrides)


def compose_from(folders: Sequence[Path], verb: str, overrides: Sequence[str]) -> DictConfig:
    """The same from given folders.

    Args:
        folders: configuration folders, first searched first; the last one ships with dr_lab.
        verb: root configuration.
        overrides: as on the command line.

    Raises:
        hydra.errors.ConfigCompositionException: an override names nothing.
    """
    return _composed(folders, verb, overrides, hydra.compose)


def require_one_run(folders: Sequence[Path], verb: str, overrides: Sequence[str]) -> None:
    """Refuse a configuration that asks for many runs where one is to be made; arguments as of `compose_from`.

    Raises:
        ConfigError: it tries several values; the message has the command that does.
        hydra.errors.ConfigCompositionException: an override names nothing.
    """
    cfg = _composed(folders, verb, overrides, functools.partial(hydra.compose, return_hydra_config=True))
    require_no_search(cfg.hydra.sweeper, verb, overrides)


def require_no_search(sweeper: DictConfig, verb: str, overrides: Sequence[str]) -> None:
    """Refuse a sweeper that tries several values where one run is to be made.

    Args:
        sweeper: of Hydra's node.
        verb: that is to run.
        overrides: as on the command line.

    Raises:
        ConfigError: it does; the message has the command for it.
    """
    params = OmegaConf.select(sweeper, "params")
    if params:
        raise ConfigError(
            f"This configuration tries several values of {', '.join(map(str, params))}, which is a sweep and takes -m: "
            f"dr-lab {verb} -m {' '.join(overrides)}"
        )


def _composed(
    folders: Sequence[Path], verb: str, overrides: Sequence[str], make: Callable[..., DictConfig]
) -> DictConfig:
    prepare(folders)
    with _beside_a_job(), hydra.initialize_config_dir(version_base=HYDRA_VERSION, config_dir=str(folders[-1])):
        return composed(overrides, lambda spelt: make(config_name=verb, overrides=spelt))[1]


@contextmanager
def _beside_a_job() -> Iterator[None]:
    """Let a job that Hydra runs compose another configuration: Hydra allows one composer at a time."""
    running = GlobalHydra.instance().hydra
    GlobalHydra.instance().clear()
    try:
        yield
    finally:
        if running is not None:
            GlobalHydra.instance().initialize(running)  # another instance, which the composer left


def compose_with_hydra(config_name: str, overrides: Sequence[str], folders: Sequence[Path]) -> DictConfig:
    """The same with Hydra's own node, and without complaint about a group that still needs a choice.

    Args:
        config_name: root configuration.
        overrides: as on the command line.
        folders: configuration folders, first searched first.
    """
    prepare(folders)
    return _with_hydra_node(config_name, overrides, folders)


def compose_outline(config_name: str, overrides: Sequence[str], folders: Sequence[Path]) -> DictConfig:
    """The same, faster: an option ``all`` brings nothing of what it stands for, which is most of a configuration.

    Args:
        config_name: root configuration.
        overrides: as on the command line.
        folders: configuration folders, first searched first.

    Raises:
        hydra.errors.ConfigCompositionException: an override names nothing, or something that ``all`` would bring.
    """
    prepare(folders)
    OmegaConf.register_new_resolver("every", lambda group: OmegaConf.create([]), replace=True)
    return _with_hydra_node(config_name, overrides, folders)


def _with_hydra_node(config_name: str, overrides: Sequence[str], folders: Sequence[Path]) -> DictConfig:
    with hydra.initialize_config_dir(version_base=HYDRA_VERSION, config_dir=str(folders[-1])):
        loader = GlobalHydra.instance().config_loader()
        # Composition for a sweep is the mode in which Hydra tolerates a mandatory group without a choice.
        return loader.load_configuration(config_name, list(overrides), RunMode.MULTIRUN)


def choices(cfg: DictConfig) -> dict[str, str | None]:
    """The groups of a verb and their chosen options, without internal ones and those nested in another (``a@b.c``).

    Args:
        cfg: configuration with Hydra's node.
    """
    chosen = OmegaConf.to_container(cfg.hydra.runtime.choices)
    if not isinstance(chosen, dict):
        return {}
    shown = {str(group): option for group, option in reversed(chosen.items()) if "@" not in str(group)}
    return {group: option for group, option in shown.items() if group.split("/")[0] not in INTERNAL_GROUPS}
