"""Composing a verb's configuration: search path, resolvers, and whole groups as one option."""

import functools
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import ClassVar

import hydra
import yaml
from hydra.core.config_search_path import ConfigSearchPath
from hydra.core.config_store import ConfigStore
from hydra.core.global_hydra import GlobalHydra
from hydra.core.plugins import Plugins
from hydra.plugins.search_path_plugin import SearchPathPlugin
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from dr_lab.cli import folders as places
from dr_lab.cli.overrides import composed
from dr_lab.cli.recorded import recorded
from dr_lab.errors import ConfigError
from dr_lab.sweeps.sweep import sweep_name

HYDRA_VERSION = "1.3"
WHOLE_GROUP = "all"
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
    OmegaConf.register_new_resolver("examples", places.example, replace=True)
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
    _offer_whole_groups(folders)


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
    prepare(folders)
    with _beside_a_job(), hydra.initialize_config_dir(version_base=HYDRA_VERSION, config_dir=str(folders[-1])):
        return composed(overrides, lambda spelt: hydra.compose(config_name=verb, overrides=spelt))[1]


@contextmanager
def _beside_a_job() -> Iterator[None]:
    """Let a job that Hydra runs compose another configuration: Hydra allows one composer at a time."""
    place = GlobalHydra.instance()
    running, place.hydra = place.hydra, None
    try:
        yield
    finally:
        place.hydra = running


def compose_with_hydra(config_name: str, overrides: Sequence[str], folders: Sequence[Path]) -> DictConfig:
    """The same with Hydra's own node, and without complaint about a group that still needs a choice.

    Args:
        config_name: root configuration.
        overrides: as on the command line.
        folders: configuration folders, first searched first.
    """
    prepare(folders)
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


def options(group: str, folders: Sequence[Path]) -> dict[str, Path]:
    """The options of a group, sorted; a user's file hides ours of the same name.

    Args:
        group: e.g. ``"model"``.
        folders: configuration folders, first searched first.

    Returns:
        File by option.
    """
    files = {path.stem: path for folder in reversed(folders) for path in (folder / group).glob("*.yaml")}
    return dict(sorted(files.items()))


def nested_options(group: str, folders: Sequence[Path]) -> list[str]:
    """The options of a group that lie in folders of it, such as ``hopper/torso_size``, sorted.

    A folder that a defaults list of the group's options names is a group of its own.

    Args:
        group: e.g. ``"env/context"``.
        folders: configuration folders, first searched first.
    """
    groups = {name for path in options(group, folders).values() for name in _subgroups(path)}
    found = {p.relative_to(folder / group) for folder in folders for p in (folder / group).glob("*/**/*.yaml")}
    return sorted(path.with_suffix("").as_posix() for path in found if path.parts[0] not in groups)


def _subgroups(path: Path) -> Iterator[str]:
    """What an option's defaults list calls the groups that lie in folders beside it."""
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except yaml.YAMLError:  # said where the option is chosen
        return
    for entry in content.get("defaults", ()) if isinstance(content, dict) else ():
        for key in entry if isinstance(entry, dict) else ():
            yield re.split("[/@]", str(key).split()[-1])[0]


def combines(files: dict[str, Path]) -> bool:
    """Whether a group's options stand side by side: each declares a package of its own, ``<something>.<option>``.

    Raises:
        ConfigError: some do and some do not.
    """
    for fault in misplaced(files).values():
        raise ConfigError(fault)
    return bool(_beside(files))


def misplaced(files: dict[str, Path]) -> dict[str, str]:
    """What is wrong with options that do not stand beside their neighbours, though these stand side by side."""
    beside = _beside(files)
    package = next(iter(beside.values()), "")
    return {
        name: f"{path}: its first line must be '# @package {package}.{name}', as its neighbours have."
        for name, path in files.items()
        if beside and name not in beside
    }


def _beside(files: dict[str, Path]) -> dict[str, str]:
    """The options that declare a package of their own, and the ``<something>`` before their name in it."""
    headers = {name: path.read_text(encoding="utf-8").partition("\n")[0].split() for name, path in files.items()}
    return {
        name: words[-1].removesuffix(f".{name}")
        for name, words in headers.items()
        if words[:2] == ["#", "@package"] and words[-1].endswith(f".{name}")
    }


def _complete(files: dict[str, Path]) -> list[str]:
    """The options that ask the user for nothing."""
    return [name for name, path in files.items() if ": ???" not in path.read_text(encoding="utf-8")]


def _offer_whole_groups(folders: Sequence[Path]) -> None:
    """Give every group of side-by-side options the option `all`, so that a new file joins the catalogue by itself.

    An option that leaves a value to the user (``???``) is not part of it.

    A group with a misplaced file has none, which stops only those who ask for it.
    """
    groups = {path.name for folder in folders for path in folder.iterdir() if path.is_dir()}
    for group in sorted(groups):
        files = options(group, folders)
        ConfigStore.instance().repo.get(group, {}).pop(f"{WHOLE_GROUP}.yaml", None)  # of an earlier composition
        if not misplaced(files) and combines(files):
            ConfigStore.instance().store(
                WHOLE_GROUP, {"defaults": _complete(files)}, group=group, package="_global_", provider="dr_lab"
            )
