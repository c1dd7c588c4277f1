"""The presets of joblib and submitit set what these know, and every preset builds its launcher."""

from pathlib import Path

import hydra
import pytest
from hydra._internal.callbacks import Callbacks
from hydra.core.config_store import ConfigStore
from hydra.core.global_hydra import GlobalHydra
from hydra.core.plugins import Plugins
from hydra.types import HydraContext, RunMode
from omegaconf import DictConfig, OmegaConf

from dr_lab.cli.compose import HYDRA_VERSION, compose_with_hydra
from dr_lab.cli.folders import shipped
from dr_lab.cli.hydra_node import check_hydra

PRESETS = sorted(path.stem for path in (shipped() / "hydra/launcher").glob("*.yaml"))
STOCK = {"cores": "joblib", "processes": "submitit_local", "slurm": "submitit_slurm"}


@pytest.mark.parametrize("preset", PRESETS)
def test_builds_its_launcher(preset: str, tmp_path: Path) -> None:
    with hydra.initialize_config_dir(version_base=HYDRA_VERSION, config_dir=str(shipped())):
        loader = GlobalHydra.instance().config_loader()
        overrides = [f"hydra/launcher={preset}", f"hydra.sweep.dir={tmp_path}"]
        config = loader.load_configuration("record", overrides, RunMode.MULTIRUN)
        launcher = Plugins.instance().instantiate_launcher(HydraContext(loader, Callbacks()), print, config)
        assert config.hydra.launcher._target_.endswith(f".{type(launcher).__name__}")


@pytest.mark.parametrize("preset", [*PRESETS, *STOCK.values()])
def test_is_sound(preset: str) -> None:
    check_hydra(compose_with_hydra("record", [f"hydra/launcher={preset}", "hydra.mode=MULTIRUN"], (shipped(),)))


def test_what_slurm_prints_lies_alone() -> None:
    # Its files are named after jobs to be cancelled, those of `processes` after processes of this machine.
    texts = [(shipped() / f"hydra/launcher/{preset}.yaml").read_text(encoding="utf-8") for preset in STOCK]
    folders = [line.split()[1] for text in texts for line in text.splitlines() if line.startswith("submitit_folder:")]
    assert len(set(folders)) == len(folders) == 2


@pytest.mark.parametrize("preset", STOCK)
def test_sets_what_its_package_knows(preset: str) -> None:
    Plugins.instance()  # whose packages bring their own settings
    stock = ConfigStore.instance().load(f"hydra/launcher/{STOCK[preset]}.yaml").node
    ours = OmegaConf.load(shipped() / f"hydra/launcher/{preset}.yaml")
    assert isinstance(stock, DictConfig)
    assert isinstance(ours, DictConfig)
    assert ours._target_ == stock._target_
    assert set(map(str, ours)) <= set(map(str, stock))
