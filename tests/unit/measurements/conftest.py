"""The shipped thresholds of the data contract, and a pendulum's motion known to 1e-10."""

from pathlib import Path

import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf

from dr_lab.measurements.contract import DataContract

_DEFAULT = Path(__file__).parents[3] / "conf" / "data_contract" / "default.yaml"


@pytest.fixture(scope="session")
def contract() -> DataContract:
    return instantiate(OmegaConf.load(_DEFAULT))
