"""What makes tests cheaper and changes nothing that they see.

1. Texts are parsed once.
2. The same choice of files is composed once.
3. Cycles are looked for less often.
"""

import gc
import io
import os
import pickle
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import IO, Any

from hydra._internal import config_loader_impl as loader
from hydra._internal.config_repository import IConfigRepository
from hydra._internal.defaults_list import DefaultsList, create_defaults_list
from hydra.core.default_element import ResultDefault
from hydra.core.override_parser.types import Override
from omegaconf import DictConfig, ListConfig, OmegaConf
from omegaconf.errors import InterpolationResolutionError

SHIPPED = str(Path(__file__).parents[1] / "conf")
_parsed: dict[str, bytes] = {}
_chosen: dict[tuple[object, ...], DefaultsList] = {}
_merged: dict[int, bytes] = {}  # by the identity of a list that stays in _chosen


def parse_once() -> None:
    """Let ``OmegaConf.load`` give copies of what it made of the same text: Hydra loads some 30 files for a command."""
    load = OmegaConf.load

    def loaded_text(file_: IO[Any]) -> DictConfig | ListConfig:
        source = file_.read()
        if source not in _parsed:
            file_.seek(0)
            _parsed[source] = pickle.dumps(load(file_))
        return pickle.loads(_parsed[source])

    @wraps(load)
    def loaded(file_: str | Path | IO[Any]) -> DictConfig | ListConfig:
        if isinstance(file_, str | Path):
            with open(os.path.abspath(file_), encoding="utf-8") as file:
                return loaded_text(file)
        return loaded_text(file_) if isinstance(file_, io.TextIOBase) and file_.seekable() else load(file_)

    OmegaConf.load = staticmethod(loaded)


def compose_once() -> None:
    """Let Hydra choose and merge the shipped files once for all commands that choose the same ones.

    What it does afterwards, such as setting values, is done for each command.
    """
    choose, merge = create_defaults_list, loader.ConfigLoaderImpl._compose_config_from_defaults_list

    @wraps(choose)
    def chosen(
        repo: IConfigRepository,
        config_name: str | None,
        overrides_list: list[Override],
        prepend_hydra: bool,
        skip_missing: bool,
    ) -> DefaultsList:
        sources = tuple(f"{source.scheme()}://{source.path}" for source in repo.get_sources())
        given = [each for each in overrides_list if not each.is_sweep_override()]
        groups = [not isinstance(each.value(), dict) and repo.group_exists(each.key_or_group) for each in given]
        lines = tuple(each.input_line for each, group in zip(given, groups, strict=True) if group)
        asked = (sources, config_name, lines, prepend_hydra, skip_missing, _every())
        if asked not in _chosen:
            found = choose(repo, config_name, overrides_list, prepend_hydra, skip_missing)
            if any(source.startswith("file://") and source != f"file://{SHIPPED}" for source in sources):
                return found  # a test may write these files anew
            _chosen[asked] = found
        values = [each for each, group in zip(given, groups, strict=True) if not group]
        return replace(_chosen[asked], config_overrides=values)

    @wraps(merge)
    def merged(self: loader.ConfigLoaderImpl, defaults: list[ResultDefault], repo: IConfigRepository) -> DictConfig:
        if not any(defaults is each.defaults for each in _chosen.values()):
            return merge(self, defaults, repo)
        if id(defaults) not in _merged:
            _merged[id(defaults)] = pickle.dumps(merge(self, defaults, repo))
        return pickle.loads(_merged[id(defaults)])

    loader.create_defaults_list = chosen  # pyright: ignore[reportPrivateImportUsage]
    loader.ConfigLoaderImpl._compose_config_from_defaults_list = merged


def _every() -> tuple[str, ...]:
    """What ``${every:effect}`` stands for, which an outline leaves out; its fault, where it has one."""
    if not OmegaConf.has_resolver("every"):
        return ()
    try:
        return tuple(OmegaConf.create({"all": "${every:effect}"})["all"])
    except InterpolationResolutionError as fault:
        return (str(fault),)


def look_for_cycles_rarely() -> None:
    """Let Python look for cycles after 50 000 new objects and not after 700."""
    gc.set_threshold(50_000, 20, 20)


def keep_what_is_loaded() -> None:
    """Spare Python from going through all modules and tests whenever it looks for cycles: they stay to the end."""
    gc.collect()
    gc.freeze()
