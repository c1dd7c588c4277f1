"""Only a run of the same verb is gone on with."""

from pathlib import Path

import pytest
from omegaconf import OmegaConf

from dr_lab.cli.resuming import require_same_settings
from dr_lab.errors import ConfigError


def test_a_run_of_another_verb_is_told_as_such_and_not_by_its_settings(tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text("# dr-lab close model=robot\nmodel: {name: robot}\n")
    with pytest.raises(ConfigError, match=r"is a run of dr-lab close\. Give resume=FOLDER of a run of dr-lab train"):
        require_same_settings(OmegaConf.create({"frames": 1}), tmp_path, "train", ("frames",))
    require_same_settings(OmegaConf.create({"model": {"name": "robot"}}), tmp_path, "close", ())
