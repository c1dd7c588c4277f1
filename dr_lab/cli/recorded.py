"""A part of an earlier run's configuration as a part of a new one."""

from pathlib import Path

from omegaconf import DictConfig, ListConfig, OmegaConf

from dr_lab.errors import ConfigError
from dr_lab.run_command import CONFIG_FILE


def recorded(run: str, key: str) -> DictConfig | ListConfig:
    """A group of what a run was configured with; the resolver ``${recorded:FOLDER,model}``.

    It is checked like what stands in the new configuration itself. A training run has its machine below ``env``.

    Args:
        run: the run folder.
        key: of its configuration.

    Returns:
        The group, its own interpolations resolved; an empty one where the run has no such key.

    Raises:
        ConfigError: the folder is not that of a run.
    """
    folder = Path(run).expanduser()
    path = folder / CONFIG_FILE
    remedy = "Give the folder of a run of dr-lab close, add or fit, or of a training that learnt a Gaussian."
    if not folder.is_dir():
        raise ConfigError(f"There is no folder {folder}. {remedy}")
    if not path.is_file():
        raise ConfigError(f"run={run} holds no {CONFIG_FILE}. {remedy}")
    config = OmegaConf.load(path)
    of_training = OmegaConf.select(config, f"env.{key}", default=OmegaConf.create({}))
    found = OmegaConf.select(config, key, default=of_training)
    return OmegaConf.create(OmegaConf.to_container(found, resolve=True))
