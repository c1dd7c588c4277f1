"""Settings of conf/env, built as `dr-lab train` would build them."""

from functools import cache
from pathlib import Path

import hydra
from omegaconf import DictConfig, OmegaConf

from dr_lab.cli.compose import HYDRA_VERSION, prepare
from dr_lab.cli.folders import shipped
from dr_lab.envs.setting import Setting


@cache
def composed(*overrides: str) -> DictConfig:
    """The group ``env`` alone, e.g. of ``env=hopper``; resolved, for other tests look for files in other folders."""
    folder: Path = shipped()
    prepare((folder,))
    with hydra.initialize_config_dir(version_base=HYDRA_VERSION, config_dir=str(folder)):
        name, *rest = overrides
        found = hydra.compose(overrides=[f"+{name}", *rest]).env
        OmegaConf.resolve(found)
        return found


@cache
def setting(name: str, *overrides: str) -> Setting:
    """A setting, e.g. ``setting("hopper", "env/context=hopper/friction")``."""
    return hydra.utils.instantiate(composed(f"env={name}", *overrides), _convert_="all")
