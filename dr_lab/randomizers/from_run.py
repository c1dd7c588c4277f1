"""Randomise around what a run of `dr-lab close` found: a closed gap is a distribution to train on."""

from pathlib import Path

import numpy as np
import yaml

from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.gaussian import GaussianRandomizer

FILE = "context.yaml"
SCHEMA = "dr_lab/context/1"


def from_run(space: ContextSpace, run: str, clip: bool) -> GaussianRandomizer:
    """The Gaussian of a fitted context: its values, its full covariance.

    Args:
        space: the parameters of the model that is trained on: the run's model with the effects that it added.
        run: the run folder, or its `context.yaml`.
        clip: whether samples are moved to the nearest admissible context.

    Raises:
        ConfigError: there is no such file, or it is not a fitted context.
        UnknownNameError: run and model do not have the same parameters.
    """
    path = Path(run).expanduser()
    path = path / FILE if path.is_dir() else path
    if not path.is_file():
        raise ConfigError(f"randomizer.run={run} has no {FILE}. Give the folder of a run of dr-lab close, fit or add.")
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        raise ConfigError(f"{path} is no fitted context: expected schema {SCHEMA}.")
    names = [str(name) for name in content["names"]]
    for name in set(names) ^ set(space.names):
        if name in names:
            raise UnknownNameError("parameter", name, space.names, f"the model; {path} has it (is an effect missing?)")
        raise UnknownNameError("parameter", name, names, f"{path}; the model has it")
    order = [names.index(name) for name in space.names]
    mean = np.asarray(content["mean"], dtype=float)[order]
    covariance = np.asarray(content["covariance"], dtype=float)[np.ix_(order, order)]
    return GaussianRandomizer(space, mean, covariance, clip)
